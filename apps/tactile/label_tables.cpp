#include "label_tables.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <tuple>

#include "tactile/core/duration_units.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/robust_statistics.hpp"
#include "text_table.hpp"

namespace tactile::cli {
namespace {

std::string ms(const std::optional<microseconds>& time) { return time ? fmt::format("{:.1f}", in_ms(*time)) : "-"; }

nlohmann::json us_or_null(const std::optional<microseconds>& time) {
  return time ? nlohmann::json(time->count()) : nlohmann::json(nullptr);
}

constexpr microseconds widest_clock = 20ms;

const labels::LabelledInterval* first_of(const labels::Labels& labels, Touch touch) {
  const auto found = std::find_if(labels.intervals.begin(), labels.intervals.end(),
                                  [&](const labels::LabelledInterval& interval) { return interval.touch == touch; });
  return found == labels.intervals.end() ? nullptr : &*found;
}

std::optional<microseconds> lag_of(const labels::Labels& labels) {
  const labels::LabelledInterval* slip = first_of(labels, Touch::slip);
  if (slip == nullptr || !slip->evidence.robot) return std::nullopt;
  const alignment::FittedClock* clock = labels.robot_clock_at(slip->start.at);
  if (clock == nullptr || clock->uncertainty() > widest_clock) return std::nullopt;  // it would say more of the clock
  return between(*slip->evidence.robot, slip->start.at);
}

std::string onset_text(const LabelledRun& labelled, Touch touch) {
  const labels::LabelledInterval* interval = first_of(labelled.labels, touch);
  if (interval == nullptr) return "-";
  return fmt::format("{:.4f} ±{}", in_s(between(labelled.zero, interval->start.at)),
                     ms(between(interval->start.low, interval->start.high) / 2));
}

std::string length_text(const labels::Labels& labels, Touch touch) {
  const labels::LabelledInterval* interval = first_of(labels, touch);
  return interval == nullptr ? "-" : ms(between(interval->start.at, interval->end.at));
}

std::size_t standing_flags(const labels::Labels& labels) {
  return static_cast<std::size_t>(
      std::count_if(labels.flags.begin(), labels.flags.end(), [](const labels::LabelFlag& flag) { return !flag.confirmed; }));
}

/// The robot's clock where it matters most: at the slip, else at the first touch.
const alignment::FittedClock* robot_clock_of(const labels::Labels& labels) {
  const labels::LabelledInterval* slip = first_of(labels, Touch::slip);
  if (slip == nullptr && !labels.intervals.empty()) slip = &labels.intervals.front();
  if (slip != nullptr) return labels.robot_clock_at(slip->start.at);
  return labels.robot_clocks.empty() ? nullptr : &labels.robot_clocks.front();
}

/// Methods by which clocks were found. Each has a letter, because the names are too long for a table.
class ClockMethods {
 public:
  explicit ClockMethods(const std::vector<LabelledRun>& runs) {
    for (const LabelledRun& labelled : runs) {
      if (const alignment::FittedClock* clock = robot_clock_of(labelled.labels)) ++uses_[clock->method];
      if (labelled.labels.video_clock) ++video_uses_[labelled.labels.video_clock->method];
    }
  }

  /// "a" to "z", then "27" and so on.
  std::string letter_of(const std::string& method) const {
    const auto index = std::distance(uses_.begin(), uses_.find(method));
    return index < 26 ? std::string(1, static_cast<char>('a' + index)) : std::to_string(index + 1);
  }

  /// "Method a: the model of the run (92 runs)."
  std::string legend() const {
    std::string text;
    for (const auto& [method, uses] : uses_) text += line("Method " + letter_of(method), method, uses);
    return text;
  }
  /// The same for the video's clock.
  std::string video_legend() const {
    std::string text;
    for (const auto& [method, uses] : video_uses_) text += line("Video clock", method, uses);
    return text;
  }

 private:
  static std::string line(const std::string& clock, const std::string& method, std::size_t uses) {
    return wrapped(fmt::format("{}: {} ({}).", clock, method.empty() ? "method not known" : method,
                               uses == 1 ? "1 run" : fmt::format("{} runs", uses)),
                   2) +
           "\n";
  }

  std::map<std::string, std::size_t> uses_, video_uses_;
};

/// Median and spread of what was measured several times.
struct Measured {
  std::size_t n = 0;
  double median = 0;
  double spread = 0;  ///< 1.4826 times the median absolute deviation: the standard deviation, of normal errors
  double least = 0;
  double largest = 0;
};

Measured measured(const std::vector<double>& values) {
  if (values.empty()) return {};
  const double middle = median(values), spread = sigma_per_median * median(distances_from(middle, values));
  const auto [least, largest] = std::minmax_element(values.begin(), values.end());
  return {.n = values.size(), .median = middle, .spread = spread, .least = *least, .largest = *largest};
}

std::vector<std::string> cells_of(const Measured& m) {
  if (m.n == 0) return {"0", "-", "-", "-", "-"};
  return {std::to_string(m.n), fmt::format("{:.1f}", m.median), m.n < 2 ? "-" : fmt::format("{:.1f}", m.spread),
          fmt::format("{:.1f}", m.least), fmt::format("{:.1f}", m.largest)};
}

void add_measured(nlohmann::json& object, const Measured& m) {
  object["n"] = m.n;
  const auto if_enough = [&](double value, std::size_t least_n) {
    return m.n >= least_n ? nlohmann::json(value) : nlohmann::json(nullptr);
  };
  object["median_ms"] = if_enough(m.median, 1);
  object["spread_ms"] = if_enough(m.spread, 2);
  object["least_ms"] = if_enough(m.least, 1);
  object["largest_ms"] = if_enough(m.largest, 1);
}

struct ObjectSummary {
  std::size_t runs = 0, flagged = 0;
  std::vector<double> lags_ms;
};

std::map<std::string, ObjectSummary> objects_of(const std::vector<LabelledRun>& runs) {
  std::map<std::string, ObjectSummary> objects;
  for (const LabelledRun& labelled : runs) {
    ObjectSummary& object = objects[labelled.run.object];
    ++object.runs;
    object.flagged += is_flagged(labelled) ? 1 : 0;
    if (const auto lag = lag_of(labelled.labels)) object.lags_ms.push_back(in_ms(*lag));
  }
  return objects;
}

/// Differences of one kind: onsets of a class by one source less those by another, the robot's through clocks of one method.
struct DifferenceKind {
  Touch touch = Touch::none;
  int of = 0, less = 0;  ///< indices of sources
  std::optional<std::string> clock_method;

  friend bool operator<(const DifferenceKind& a, const DifferenceKind& b) {
    return std::tie(a.touch, a.of, a.less, a.clock_method) < std::tie(b.touch, b.of, b.less, b.clock_method);
  }
};

constexpr std::array<const char*, 4> source_names{"events", "robot", "video", "IMU"};
constexpr std::array<const char*, 4> source_keys{"events", "robot", "video", "imu"};
constexpr int robot_source = 1;

std::map<DifferenceKind, std::vector<double>> differences_of(const std::vector<LabelledRun>& runs) {
  std::map<DifferenceKind, std::vector<double>> differences;
  for (const LabelledRun& labelled : runs) {
    for (const labels::LabelledInterval& interval : labelled.labels.intervals) {
      const labels::Evidence& evidence = interval.evidence;
      const std::array<std::optional<CameraTime>, 4> by{evidence.events, evidence.robot, evidence.video, evidence.imu};
      for (int of = 0; of < 4; ++of) {
        for (int less = of + 1; less < 4; ++less) {
          const auto &a = by[static_cast<std::size_t>(of)], &b = by[static_cast<std::size_t>(less)];
          if (!a || !b) continue;
          DifferenceKind kind{.touch = interval.touch, .of = of, .less = less, .clock_method = std::nullopt};
          if (of == robot_source || less == robot_source) {
            const alignment::FittedClock* clock = labelled.labels.robot_clock_at(interval.start.at);
            kind.clock_method = clock == nullptr ? "" : clock->method;
          }
          differences[kind].push_back(in_ms(between(*b, *a)));
        }
      }
    }
  }
  return differences;
}

std::size_t presses_of(const labels::Labels& labels) {
  return static_cast<std::size_t>(
      std::count_if(labels.intervals.begin(), labels.intervals.end(),
                    [](const labels::LabelledInterval& interval) { return interval.touch == Touch::press; }));
}

bool has_session(const RunFolder& run) {
  try {
    return !read_run_info(run).session.empty();
  } catch (const Error&) {
    return false;
  }
}

/// Advice on clocks that were fitted to one run each, of runs without a session: who gave one knows of it.
std::string advice_on_sessions(const std::vector<LabelledRun>& runs) {
  const auto is_alone = [](const LabelledRun& labelled) {
    const alignment::FittedClock* clock = robot_clock_of(labelled.labels);
    return clock != nullptr && clock->uncertainty() > 5ms && clock->method.find("of a session") == std::string::npos &&
           !has_session(labelled.run);
  };
  if (std::count_if(runs.begin(), runs.end(), is_alone) < 2) return {};
  return wrapped(
             "Runs that were recorded without a restart of camera and controller share their clocks. Label such runs "
             "together with --session NAME: then one clock is fitted to all of them, and is more accurate.") +
         "\n";
}

}  // namespace

bool is_flagged(const LabelledRun& labelled) { return standing_flags(labelled.labels) > 0; }

std::string runs_table(const std::vector<LabelledRun>& runs, bool with_methods) {
  const ClockMethods methods(runs);
  std::vector<std::vector<std::string>> rows;
  for (const LabelledRun& labelled : runs) {
    const alignment::FittedClock* clock = robot_clock_of(labelled.labels);
    const std::string clock_text =
        clock == nullptr ? "-"
                         : fmt::format("{}±{}", with_methods ? methods.letter_of(clock->method) + " " : "",
                                       ms(microseconds{saturating_subtract(clock->offset_high_us, clock->offset_low_us)} / 2));
    const std::size_t standing = standing_flags(labelled.labels);
    rows.push_back({labelled.run.run, onset_text(labelled, Touch::press), length_text(labelled.labels, Touch::press),
                    onset_text(labelled, Touch::slip), length_text(labelled.labels, Touch::slip), ms(lag_of(labelled.labels)),
                    clock_text, standing == 0 ? "" : std::to_string(standing)});
  }
  // An object's name on a line of its own leaves the width to what was measured.
  const std::string table = text_table({"run", "press at", "lasts", "slip at", "lasts", "lift to slip", "clock", "flags"}, rows);
  std::size_t begin = table.find('\n') + 1;
  std::string text = table.substr(0, begin), object;
  for (const LabelledRun& labelled : runs) {
    if (labelled.run.object != object) text += (object = labelled.run.object) + "\n";
    const std::size_t end = table.find('\n', begin) + 1;
    text += table.substr(begin, end - begin);
    begin = end;
  }
  for (const LabelledRun& labelled : runs) {
    if (const std::size_t presses = presses_of(labelled.labels); presses > 1)
      text += wrapped(fmt::format("{}: {} presses; the first is shown", labelled.run.name(), presses), 2) + "\n";
    for (const labels::LabelFlag& flag : labelled.labels.flags) {
      text += wrapped(fmt::format("{}{}: {}{}", labelled.run.name(),
                                  flag.interval_index ? " " + labelled.labels.intervals.at(*flag.interval_index).id : "",
                                  flag.reason, flag.confirmed ? " (confirmed by a person)" : ""),
                      2) +
              "\n";
    }
  }
  const bool has_lag =
      std::any_of(runs.begin(), runs.end(), [](const LabelledRun& labelled) { return lag_of(labelled.labels).has_value(); });
  const bool has_negative_lag = std::any_of(runs.begin(), runs.end(), [](const LabelledRun& labelled) {
    const auto lag = lag_of(labelled.labels);
    return lag && *lag < 0us;
  });
  const bool since_first = runs.front().zero == runs.front().first_event;
  std::string legend = fmt::format("Onsets in seconds {}, all other times in ms; ± is half of an onset's 95 % interval.",
                                   since_first ? "since a run's first event" : "of the camera's clock");
  if (!methods.legend().empty()) {
    legend += fmt::format(" For a clock, {}± is half of its offset's 95 % interval.",
                          with_methods ? "the letter is the method that found it, and " : "");
  }
  if (has_lag) legend += " Lift to slip includes the robot clock's error.";
  if (has_negative_lag) legend += " A negative value is this error, or the robot log is of another recording.";
  return text + wrapped(legend) + "\n" + (with_methods ? methods.legend() : "") + advice_on_sessions(runs);
}

std::string remarks_text(const std::vector<LabelledRun>& runs) {
  std::map<std::string, std::vector<std::string>> runs_of;  // many runs share a remark
  for (const LabelledRun& labelled : runs) {
    for (const std::string& remark : labelled.labels.remarks) runs_of[remark].push_back(labelled.run.name());
  }
  if (runs_of.empty()) return {};
  std::string text = "Remarks:\n";
  for (const auto& [remark, names] : runs_of) text += wrapped(fmt::format("  {}: {}", fmt::join(names, ", "), remark), 4) + "\n";
  return text;
}

nlohmann::json runs_json(const std::vector<LabelledRun>& runs) {
  nlohmann::json result = nlohmann::json::array();
  for (const LabelledRun& labelled : runs) {
    nlohmann::json intervals = nlohmann::json::array();
    for (const labels::LabelledInterval& interval : labelled.labels.intervals) {
      intervals.push_back({{"id", interval.id},
                           {"class", name_of(interval.touch)},
                           {"start_us", us_of(interval.start.at)},
                           {"start_low_us", us_of(interval.start.low)},
                           {"start_high_us", us_of(interval.start.high)},
                           {"end_us", us_of(interval.end.at)},
                           {"visible_us", interval.visible ? nlohmann::json(us_of(*interval.visible)) : nlohmann::json()},
                           {"probability", interval.probability ? nlohmann::json(*interval.probability) : nlohmann::json()},
                           {"confirmed", interval.confirmed}});
    }
    nlohmann::json flags = nlohmann::json::array();
    for (const labels::LabelFlag& flag : labelled.labels.flags) flags.push_back(flag.reason);
    const alignment::FittedClock* clock = robot_clock_of(labelled.labels);
    result.push_back({{"run", labelled.run.name()},
                      {"first_event_us", us_of(labelled.first_event)},
                      {"intervals", intervals},
                      {"lift_to_slip_us", us_or_null(lag_of(labelled.labels))},
                      {"robot_clock", clock == nullptr ? nlohmann::json(nullptr)
                                                       : nlohmann::json{{"method", clock->method},
                                                                        {"anchors", clock->anchors},
                                                                        {"offset_us", clock->relation.offset_us},
                                                                        {"offset_low_us", clock->offset_low_us},
                                                                        {"offset_high_us", clock->offset_high_us}}},
                      {"flags", flags},
                      {"remarks", labelled.labels.remarks},
                      {"standing_flags", standing_flags(labelled.labels)}});
  }
  return result;
}

std::string objects_table(const std::vector<LabelledRun>& runs) {
  std::vector<std::vector<std::string>> rows;
  bool has_lag = false;
  for (const auto& [name, object] : objects_of(runs)) {
    has_lag |= !object.lags_ms.empty();
    std::vector<std::string> row{name, std::to_string(object.runs), std::to_string(object.flagged)};
    for (std::string& cell : cells_of(measured(object.lags_ms))) row.push_back(std::move(cell));
    rows.push_back(std::move(row));
  }
  std::string table = text_table({"lift to slip [ms]", "runs", "flagged", "n", "median", "spread", "least", "largest"}, rows);
  if (!has_lag) return table;
  return table +
         wrapped(
             "Lift to slip is the slip onset minus the lift start. It includes the error of the robot's clock. Spread is 1.48 "
             "times the median distance from the median.") +
         "\n";
}

nlohmann::json objects_json(const std::vector<LabelledRun>& runs) {
  nlohmann::json result = nlohmann::json::array();
  for (const auto& [name, object] : objects_of(runs)) {
    nlohmann::json lag = nlohmann::json::object();
    add_measured(lag, measured(object.lags_ms));
    result.push_back({{"object", name}, {"runs", object.runs}, {"flagged", object.flagged}, {"lift_to_slip", lag}});
  }
  return result;
}

std::string differences_table(const std::vector<LabelledRun>& runs) {
  const auto differences = differences_of(runs);
  if (differences.empty()) return wrapped("No onset has more than one source, so none can be compared.") + "\n";
  const ClockMethods methods(runs);
  std::vector<std::vector<std::string>> rows;
  for (const auto& [kind, values] : differences) {
    const std::string name = fmt::format("{}, {} - {}", name_of(kind.touch), source_names[static_cast<std::size_t>(kind.of)],
                                         source_names[static_cast<std::size_t>(kind.less)]);
    std::vector<std::string> row{name, kind.clock_method ? methods.letter_of(*kind.clock_method) : ""};
    for (std::string& cell : cells_of(measured(values))) row.push_back(std::move(cell));
    rows.push_back(std::move(row));
  }
  return text_table({"onsets apart [ms]", "clock by", "n", "median", "spread", "least", "largest"}, rows) +
         wrapped(
             "Robot: when a stage command (press) or the lift (slip) began. Video: when the stage or the arm began to move. "
             "Their differences therefore include the lag from there to the onset. The robot's clock follows from all "
             "witnesses together, so its agreement with the events proves little.") +
         "\n" + methods.legend() + methods.video_legend();
}

nlohmann::json differences_json(const std::vector<LabelledRun>& runs) {
  nlohmann::json result = nlohmann::json::array();
  for (const auto& [kind, values] : differences_of(runs)) {
    nlohmann::json entry = {{"class", name_of(kind.touch)},
                            {"of", source_keys[static_cast<std::size_t>(kind.of)]},
                            {"less", source_keys[static_cast<std::size_t>(kind.less)]},
                            {"clock_method", kind.clock_method ? nlohmann::json(*kind.clock_method) : nlohmann::json(nullptr)}};
    add_measured(entry, measured(values));
    result.push_back(std::move(entry));
  }
  return result;
}

}  // namespace tactile::cli
