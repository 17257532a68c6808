#include "tactile/experiments/trade/tick_times.hpp"

#include <fmt/core.h>
#include <sys/resource.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cstring>
#include <map>
#include <memory>
#include <numeric>
#include <tuple>

#include "tactile/core/error.hpp"
#include "tactile/core/error_text.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/random.hpp"
#include "tactile/core/robust_statistics.hpp"
#include "tactile/core/ticks.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/experiments/file_step.hpp"
#include "tactile/model/training/open_classifier.hpp"

namespace tactile::trade {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::int64_t warm_up_ticks = 1;

/// Models, each opened once: several settings may share one.
class Models {
 public:
  explicit Models(OpenTimedModel open) : open_(std::move(open)) {}

  TimedModel of(const TimedSetting& setting) {
    const auto key = std::tuple(setting.model, setting.engine, setting.precision);
    const auto found = models_.find(key);
    return found != models_.end() ? found->second : models_[key] = open_(setting);
  }

 private:
  OpenTimedModel open_;
  std::map<std::tuple<std::filesystem::path, model::EngineKind, model::Precision>, TimedModel> models_;
};

struct Recorded {
  std::vector<events::Event> events;
  events::SensorSize sensor;

  TickRange ticks(const heatmaps::HeatmapOptions& rendering) const {
    return full_ticks(events.front().t, events.back().t, rendering.history, rendering.tick);
  }

  std::span<const events::Event> between(CameraTime begin, CameraTime end) const {
    const auto place = [&](CameraTime t) {
      return std::lower_bound(events.begin(), events.end(), t,
                              [](const events::Event& event, CameraTime time) { return event.t < time; });
    };
    return {place(begin), place(end)};
  }
};

Recorded events_of(const std::filesystem::path& recording) {
  events::RecordingReader reader(recording);
  const events::Stream& stream = events::event_stream(reader);
  Recorded recorded;
  recorded.sensor = stream.size.value_or(events::SensorSize{});
  events::for_all_events(reader, stream.id, [&](std::span<const events::Event> events) {
    recorded.events.insert(recorded.events.end(), events.begin(), events.end());
  });
  if (recorded.events.empty()) throw Error(recording.string() + ": no events; expected some to time detection with");
  return recorded;
}

/// The ticks of one setting in one piece of a recording.
struct Piece {
  CameraTime first{};
  std::int64_t ticks = 0;    ///< of a turn
  std::uint64_t wanted = 0;  ///< of all turns
};

Piece piece_of(const TickRange& all, unsigned piece, std::uint64_t wanted, const TickTimesOptions& options) {
  if (all.count <= 0) return {};
  const auto ticks = std::min(static_cast<std::int64_t>((wanted + options.turns - 1) / options.turns), all.count);
  const double middle = (piece + 0.5) / options.pieces * static_cast<double>(all.count);
  const auto begin = std::clamp<std::int64_t>(static_cast<std::int64_t>(middle) - ticks / 2, 0, all.count - ticks);
  return {all.at(begin), ticks, wanted};
}

/// How often the system has taken the processor from this thread while it had work to do.
std::uint64_t interruptions() {
  rusage usage{};
  ::getrusage(RUSAGE_THREAD, &usage);
  return static_cast<std::uint64_t>(usage.ru_nivcsw);
}

/// One turn of one setting over a piece.
void take_turn(const TimedSetting& setting, const TimedModel& open, const Recorded& recorded, const Piece& piece,
               std::vector<TickTime>& times) {
  const heatmaps::HeatmapOptions& options = setting.rendering;
  const std::unique_ptr<model::EventClassifier> model = open(recorded.sensor, options);
  CameraTime given = before(piece.first, options.history + options.tick * warm_up_ticks);
  for (std::int64_t i = -warm_up_ticks; i < piece.ticks; ++i) {
    const CameraTime t = after(piece.first, options.tick * i);
    const std::span<const events::Event> events = recorded.between(given, t);
    given = t;
    const std::uint64_t interrupted_before = interruptions();
    const auto begin = Clock::now();
    model->add(events);
    model->move_to(t);
    const auto counted = Clock::now();
    model->prepare();
    const auto rendered = Clock::now();
    model->classify();
    const auto end = Clock::now();
    if (i < 0) continue;
    times.push_back({us_between(begin, counted), us_between(counted, rendered), us_between(rendered, end),
                     static_cast<std::uint32_t>(model->events()),
                     static_cast<std::uint32_t>(interruptions() - interrupted_before)});
  }
}

/// Each turn has another order, because a setting finds in the caches what the one before it left, such as the same weights.
std::vector<std::size_t> any_order(std::size_t count, Random& random) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  random.shuffle(order);
  return order;
}

/// All turns of all settings in one piece of a recording.
class PieceTimes {
 public:
  PieceTimes(std::span<const TimedSetting> settings, std::span<const TimedModel> models, const Recorded& recorded, unsigned piece,
             std::uint64_t wanted, const TickTimesOptions& options)
      : settings_(settings), models_(models), recorded_(recorded) {
    for (const TimedSetting& setting : settings)
      pieces_.push_back(piece_of(recorded.ticks(setting.rendering), piece, wanted, options));
  }

  bool due(std::size_t setting, unsigned turn) const {
    return turn * static_cast<std::uint64_t>(pieces_[setting].ticks) < pieces_[setting].wanted && pieces_[setting].ticks > 0;
  }

  bool any_due(unsigned turn) const {
    for (std::size_t i = 0; i < settings_.size(); ++i) {
      if (due(i, turn)) return true;
    }
    return false;
  }

  void take(std::size_t setting, std::vector<TickTime>& times) const {
    take_turn(settings_[setting], models_[setting], recorded_, pieces_[setting], times);
  }

 private:
  std::span<const TimedSetting> settings_;
  std::span<const TimedModel> models_;
  const Recorded& recorded_;
  std::vector<Piece> pieces_;
};

constexpr std::size_t bytes_of_tick = 20;

}  // namespace

TimedModel open_timed_model(const TimedSetting& setting) {
  const auto classifier = std::make_shared<const model::Classifier>(
      model::open_classifier(setting.model, 1, setting.engine, {.precision = setting.precision}));
  return [classifier](events::SensorSize sensor, const heatmaps::HeatmapOptions& rendering) {
    return classifier->on_events(sensor, rendering);
  };
}

std::vector<TimesOfRuns> time_ticks(std::span<const TimedSetting> settings, std::span<const std::filesystem::path> recordings,
                                    const TickTimesOptions& options, const ProgressCallback& progress,
                                    const OpenTimedModel& open) {
  Random random(1);
  Models models(open);
  std::vector<TimedModel> model_of;
  for (const TimedSetting& setting : settings) model_of.push_back(models.of(setting));
  std::vector<TimesOfRuns> times(settings.size(), TimesOfRuns(recordings.size()));
  const std::uint64_t all_pieces = std::uint64_t{recordings.size()} * options.pieces;
  const std::uint64_t wanted = (options.ticks + all_pieces - 1) / std::max<std::uint64_t>(all_pieces, 1);
  std::uint64_t done = 0;
  for (std::size_t run = 0; run < recordings.size(); ++run) {
    const Recorded recorded = events_of(recordings[run]);
    for (unsigned index = 0; index < options.pieces; ++index) {
      const PieceTimes piece(settings, model_of, recorded, index, wanted, options);
      for (unsigned turn = 0; piece.any_due(turn); ++turn) {
        for (const std::size_t i : any_order(settings.size(), random)) {
          if (piece.due(i, turn)) piece.take(i, times[i][run]);
        }
        report_progress(progress, done, all_pieces, fmt::format("times of {} settings, in turns", settings.size()));
      }
      ++done;
    }
  }
  return times;
}

void write_times(const std::filesystem::path& file, std::span<const TimesOfRuns> times) {
  static_assert(sizeof(TickTime) == bytes_of_tick && std::endian::native == std::endian::little);
  nlohmann::json counts = nlohmann::json::array();
  for (const TimesOfRuns& of_setting : times) {
    counts.push_back(nlohmann::json::array());
    for (const auto& run : of_setting) counts.back().push_back(run.size());
  }
  std::string text = nlohmann::json{{"ticks", counts}}.dump() + "\n";
  for (const TimesOfRuns& of_setting : times) {
    for (const auto& run : of_setting) text.append(reinterpret_cast<const char*>(run.data()), run.size() * bytes_of_tick);
  }
  write_whole(file, text);
}

std::vector<TimesOfRuns> read_times(const std::filesystem::path& file) {
  const std::string text = read_text(file, experiments::largest_step_file);
  const std::size_t line = text.find('\n');
  const auto json = nlohmann::json::parse(text.substr(0, line), nullptr, false);
  std::size_t at = line == std::string::npos ? text.size() : line + 1;
  std::vector<TimesOfRuns> times;
  try {
    for (const auto& runs : json.at("ticks")) {
      times.emplace_back();
      for (const auto& count : runs) {
        const auto ticks = count.get<std::uint64_t>();
        if (!count.is_number_unsigned() || ticks > (text.size() - at) / bytes_of_tick)
          throw Error(file.string() + ": ends before the last tick; expected 20 bytes for each tick");
        times.back().emplace_back(ticks);
        if (ticks > 0) std::memcpy(times.back().back().data(), text.data() + at, ticks * bytes_of_tick);
        at += ticks * bytes_of_tick;
      }
    }
  } catch (const nlohmann::json::exception& e) {
    throw Error(fmt::format("{}: {}; expected times of ticks", file.string(), "a value " + plain_words(e.what())));
  }
  if (at != text.size()) throw Error(file.string() + ": goes beyond the last tick; expected 20 bytes for each tick");
  return times;
}

}  // namespace tactile::trade
