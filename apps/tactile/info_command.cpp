#include <fmt/core.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "command.hpp"
#include "commands.hpp"
#include "log_rows.hpp"
#include "option_checks.hpp"
#include "quantity_text.hpp"
#include "recording_json.hpp"
#include "standard_streams.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/error_text.hpp"
#include "tactile/core/run_files.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/events/recording_health.hpp"
#include "tactile/events/simulated_recording.hpp"
#include "text_table.hpp"

namespace tactile {
namespace fs = std::filesystem;
namespace {

struct InfoArguments {
  std::vector<std::string> places;
  std::string stream;
  std::int64_t gap_ms = 100;
  bool check = false;
};

/// One thing to report on: a recording, or a run with its recording.
struct Subject {
  std::string name;  ///< as it was given
  fs::path file;
  std::optional<RunFolder> run;
};

struct Report {
  Subject subject;
  RecordingHealth health;
  std::optional<RunInfo> run;
  RunFiles files;
  std::optional<LogRows> robot, video;
};

/// What the places hold, and what of them is left out.
struct Subjects {
  std::vector<Subject> found;
  std::vector<std::string> misnamed, unreadable;
};

void add_place(const std::string& place, Subjects& subjects) {
  std::error_code unknown;
  if (!fs::is_directory(place, unknown)) return subjects.found.push_back({place, place, std::nullopt});
  const RunFolder run = run_folder_at(place);
  if (is_there(run.events())) {
    subjects.found.push_back({place, run.events(), run});
    if (const std::string why = what_is_misnamed(place); is_there(run.info()) && !why.empty()) subjects.misnamed.push_back(why);
    return;
  }
  const RunsBelow below = look_for_runs(place);
  for (const RunFolder& found : below.runs) subjects.found.push_back({found.folder.string(), found.events(), found});
  subjects.misnamed.insert(subjects.misnamed.end(), below.misnamed.begin(), below.misnamed.end());
  subjects.unreadable.insert(subjects.unreadable.end(), below.unreadable.begin(), below.unreadable.end());
  if (below.runs.empty() && below.misnamed.empty() && below.unreadable.empty())
    throw Error(place + ": no events.aedat4 in it, nor runs below it; expected a recording, a run or a folder of runs");
}

/// What run.json counts as dropped; empty if it counts nothing.
std::string drops_in(const RunInfo& run) {
  const auto dropped = run.extra.find("dropped");
  if (dropped == run.extra.end() || !dropped->is_object()) return "";
  std::string text;
  const auto add = [&](const char* key, const std::string& what) {
    const auto count = dropped->find(key);
    if (count == dropped->end() || !count->is_number_unsigned() || *count == 0) return;
    text += (text.empty() ? "" : ", ") + counted(count->get<std::uint64_t>(), what);
  };
  add("events", "event");
  add("packets", "packet");
  add("others", "other element");
  add("robot_gaps", "robot gap");
  add("robot_packages", "robot package");
  add("frames", "video frame");
  return text;
}

/// Whether run.json has the recording's own hash.
bool has_hash(const RunInfo& run, const RunFolder& folder) {
  const auto files = run.extra.find("files");
  return files != run.extra.end() && files->is_object() && files->contains(folder.events().filename().string());
}

/// What the run's own account adds to the recording's health.
void add_run(Report& report, const InfoArguments& args, const ProgressCallback& progress) {
  const RunFolder& folder = *report.subject.run;
  RecordingHealth& health = report.health;
  const SensorSize size{report.run->width, report.run->height};
  if (!report.run->complete) health.reasons.emplace_back("run.json: the run was not completed");
  for (const StreamHealth& stream : health.streams) {
    if (stream.events && stream.stream.size && *stream.stream.size != size) {
      health.reasons.push_back(fmt::format("run.json: the sensor has {}x{} pixels, but stream {} declares {}x{}", size.width,
                                           size.height, stream.stream.id, stream.stream.size->width, stream.stream.size->height));
    }
  }
  if (const std::string drops = drops_in(*report.run); !drops.empty())
    health.notes.push_back("run.json counts as dropped: " + drops);
  report.files = check_files(folder, *report.run, args.check ? FileComparison::contents : FileComparison::size, progress);
  health.reasons.insert(health.reasons.end(), report.files.reasons.begin(), report.files.reasons.end());
  if (!report.files.told && report.run->complete) {
    health.notes.emplace_back("run.json lists no files: whether they have changed cannot be told");
  } else if (report.files.told && !report.files.not_listed.empty()) {
    health.notes.push_back(fmt::format("run.json does not list {}", fmt::join(report.files.not_listed, ", ")));
  }
}

Report examine(const Subject& subject, const InfoArguments& args, unsigned threads, const ProgressCallback& progress) {
  Report report{subject, {}, std::nullopt, {}, {}, {}};
  std::string no_run;
  try {
    if (subject.run) {
      report.run = read_run_info(*subject.run);
      report.run->simulated = is_simulated(*subject.run);
    }
  } catch (const std::exception& e) {
    no_run = sentence_of(e);
  }
  const HealthOptions options{.stream = args.stream,
                              .gap = std::chrono::milliseconds(args.gap_ms),
                              .checksums = args.check && !(report.run && has_hash(*report.run, *subject.run)),
                              .threads = threads};
  report.health = examine_recording(subject.file, options, progress);
  if (!subject.run) return report;
  report.robot = log_rows(subject.run->robot(), "timestamp", 1, 0.1);
  report.video = log_rows(subject.run->video_times(), "pts_us", 1e-6, 1);
  if (!no_run.empty()) report.health.reasons.push_back(no_run);
  if (report.run) add_run(report, args, progress);
  return report;
}

std::string table_state(const RecordingHealth& health) {
  if (health.index == PacketIndex::table) return "used";
  return health.problems.table.empty() ? "missing" : "unusable";
}

/// The event stream that names the camera: the first.
const StreamHealth* main_stream(const RecordingHealth& health) {
  const auto found =
      std::find_if(health.streams.begin(), health.streams.end(), [](const StreamHealth& s) { return s.events.has_value(); });
  return found == health.streams.end() ? nullptr : &*found;
}

nlohmann::json json_or_null(const auto& optional) { return optional ? nlohmann::json(*optional) : nlohmann::json(); }

nlohmann::json json_of(const StreamHealth& stream, const InfoArguments& args) {
  const StampHealth& stamps = stream.stamps;
  const bool any = stamps.elements > 0;
  nlohmann::json gaps = nlohmann::json::array();
  for (const Gap& gap : stamps.longest_gaps) {
    gaps.push_back({{"begin_us", us_of(gap.begin)},
                    {"end_us", us_of(gap.end)},
                    {"length_us", gap.length().count()},
                    {"imu_silent", gap.imu_silent}});
  }
  nlohmann::json attributes = nlohmann::json::object();
  for (const auto& [key, value] : stream.stream.info) attributes[key] = value;
  nlohmann::json json = {
      {"id", stream.stream.id},
      {"type", name_of(stream.stream.type)},
      {"type_identifier", stream.stream.type_identifier},
      {"name", stream.stream.name},
      {"source", stream.stream.source},
      {"width", stream.stream.size ? nlohmann::json(stream.stream.size->width) : nlohmann::json()},
      {"height", stream.stream.size ? nlohmann::json(stream.stream.size->height) : nlohmann::json()},
      {"attributes", attributes},
      {"packets", stream.packets},
      {"bytes", stream.bytes},
      {"elements", stamps.elements},
      {"first_us", any ? nlohmann::json(us_of(stamps.first)) : nlohmann::json()},
      {"last_us", any ? nlohmann::json(us_of(stamps.last)) : nlohmann::json()},
      {"duration_us", stamps.duration().count()},
      {"rate_hz", json_or_null(stamps.rate_hz())},
      {"steps_back_in_packets", stamps.steps_back_in_packets},
      {"steps_back_between_packets", stamps.steps_back_between_packets},
      {"gaps",
       {{"limit_us", 1000 * args.gap_ms}, {"count", stamps.gaps}, {"silent_us", stamps.silent.count()}, {"longest", gaps}}},
  };
  if (!stream.events) return json;
  const EventHealth& events = *stream.events;
  nlohmann::json hottest = nlohmann::json::array();
  for (const HotPixel& pixel : events.hottest)
    hottest.push_back({{"x", pixel.x}, {"y", pixel.y}, {"events", pixel.events}, {"rate_hz", pixel.rate_hz}});
  json["on"] = events.on;
  json["on_share"] =
      any ? nlohmann::json(static_cast<double>(events.on) / static_cast<double>(stamps.elements)) : nlohmann::json();
  json["peak_tick_events"] = events.peak_tick_events;
  json["peak_rate_hz"] = events.peak_rate_hz;
  json["pixels_fired"] = events.pixels_counted ? nlohmann::json(events.pixels_fired) : nlohmann::json();
  json["hot_pixels"] = events.pixels_counted
                           ? nlohmann::json{{"count", events.hot_pixels}, {"events", events.hot_events}, {"hottest", hottest}}
                           : nlohmann::json();
  json["readout_period_us"] = json_or_null(events.readout_period_us);
  return json;
}

nlohmann::json json_of(const ChecksumHealth& checksums) {
  nlohmann::json damaged = nlohmann::json::array();
  for (const auto& [index, record] : checksums.first_damaged) {
    const bool has_time = record.elements > 0;
    damaged.push_back({{"packet", index},
                       {"stream", record.stream_id},
                       {"position", record.payload_offset - 8},
                       {"first_us", has_time ? nlohmann::json(us_of(record.first)) : nlohmann::json()},
                       {"last_us", has_time ? nlohmann::json(us_of(record.last)) : nlohmann::json()}});
  }
  return {{"whole", checksums.whole},
          {"damaged", checksums.damaged},
          {"not_covered", checksums.not_covered},
          {"header_damaged", checksums.header_damaged},
          {"first_damaged", damaged}};
}

nlohmann::json json_of(const Report& report, const InfoArguments& args) {
  const RecordingHealth& health = report.health;
  nlohmann::json streams = nlohmann::json::array();
  for (const StreamHealth& stream : health.streams) streams.push_back(json_of(stream, args));
  const StreamHealth* camera = main_stream(health);
  const bool has_size = camera != nullptr && camera->stream.size.has_value();
  const RecordingProblems& problems = health.problems;
  nlohmann::json json = {
      {"file", health.file.string()},
      {"file_bytes", health.file_size},
      {"compression", name_of(health.compression)},
      {"data_table", {{"state", table_state(health)}, {"why", problems.table}}},
      {"camera", camera != nullptr ? nlohmann::json(camera->stream.source) : nlohmann::json()},
      {"width", has_size ? nlohmann::json(camera->stream.size->width) : nlohmann::json()},
      {"height", has_size ? nlohmann::json(camera->stream.size->height) : nlohmann::json()},
      {"packets", health.packets()},
      {"first_us", health.first() ? nlohmann::json(us_of(*health.first())) : nlohmann::json()},
      {"last_us", health.last() ? nlohmann::json(us_of(*health.last())) : nlohmann::json()},
      {"duration_us", health.duration().count()},
      {"streams", streams},
      {"problems", json_of(problems)},
      {"checksums", health.checksums ? json_of(*health.checksums) : nlohmann::json()},
      {"healthy", health.healthy()},
      {"reasons", health.reasons},
      {"notes", health.notes},
  };
  const auto json_of_rows = [](const std::optional<LogRows>& log, const char* rows) {
    return log ? nlohmann::json{{rows, log->rows}, {"rate_hz", json_or_null(log->rate_hz)}, {"gaps", log->gaps}}
               : nlohmann::json();
  };
  json["robot"] = json_of_rows(report.robot, "rows");
  json["video"] = json_of_rows(report.video, "frames");
  json["run"] = report.run ? json_of(*report.run) : nlohmann::json();
  json["run_files"] = !report.run
                          ? nlohmann::json()
                          : nlohmann::json{{"listed", report.files.told},         {"compared", args.check ? "sha256" : "bytes"},
                                           {"as_listed", report.files.as_listed}, {"missing", report.files.missing},
                                           {"changed", report.files.changed},     {"not_listed", report.files.not_listed}};
  return json;
}

/// Lines of a label and what it says, the labels in one column.
class Lines {
 public:
  explicit Lines(std::string indent) : indent_(std::move(indent)) {}
  void add(const std::string& label, const std::string& text) { text_ += fmt::format("{}{:<12}{}\n", indent_, label, text); }
  const std::string& text() const { return text_; }

 private:
  std::string indent_, text_;
};

std::string text_of(const RunInfo& run) {
  std::string text = fmt::format("{}/{}, {}, {}", run.object, run.run, run.simulated ? "simulated" : "real",
                                 run.complete ? "complete" : "not completed");
  if (!run.session.empty()) text += ", session " + run.session;
  return text;
}

std::string files_text(const RunFiles& files, const InfoArguments& args) {
  const std::size_t bad = files.missing.size() + files.changed.size();
  std::string text = fmt::format("{} of {} as run.json lists them, by ", files.as_listed.size(), files.as_listed.size() + bad);
  return text + (args.check ? "size and SHA-256" : "size alone (--check: by SHA-256)");
}

std::string title_of(const Stream& stream) {
  const std::string type(name_of(stream.type));
  const std::string known = stream.type == StreamType::other ? type + " (" + stream.type_identifier + ")" : type;
  return fmt::format("{}  {}{}", stream.id, known, stream.name.empty() || stream.name == type ? "" : " \"" + stream.name + "\"");
}

std::string stream_table(const RecordingHealth& health) {
  const bool several_cameras = std::any_of(health.streams.begin(), health.streams.end(), [&](const StreamHealth& s) {
    return s.stream.source != health.streams.front().stream.source;
  });
  std::vector<std::string> header{"Stream", "packets", "elements", "bytes", "mean rate", "from", "to"};
  if (several_cameras) header.emplace_back("camera");
  std::vector<std::vector<std::string>> rows;
  for (const StreamHealth& stream : health.streams) {
    const StampHealth& stamps = stream.stamps;
    std::vector<std::string> row{title_of(stream.stream), std::to_string(stream.packets), std::to_string(stamps.elements),
                                 std::to_string(stream.bytes)};
    row.push_back(stamps.rate_hz() ? rate_text(*stamps.rate_hz()) : "-");
    for (const CameraTime t : {stamps.first, stamps.last}) {
      row.push_back(stamps.elements == 0
                        ? "-"
                        : fmt::format("{:.6f} s", std::chrono::duration<double>(between(*health.first(), t)).count()));
    }
    if (several_cameras) row.push_back(stream.stream.source);
    rows.push_back(std::move(row));
  }
  std::string table = text_table(header, rows);
  std::string indented = "  ";
  for (const char c : table) {
    indented += c;
    if (c == '\n') indented += "  ";
  }
  indented.resize(indented.size() - 2);
  return indented;
}

std::string gaps_text(const StampHealth& stamps, const InfoArguments& args) {
  if (stamps.gaps == 0) return fmt::format("none longer than {} ms", args.gap_ms);
  const auto longest = std::max_element(stamps.longest_gaps.begin(), stamps.longest_gaps.end(),
                                        [](const Gap& a, const Gap& b) { return a.length() < b.length(); });
  return fmt::format("{} longer than {} ms, {} in all; the longest {} from {:.6f} s on{}", stamps.gaps, args.gap_ms,
                     duration_text(stamps.silent), duration_text(longest->length()),
                     std::chrono::duration<double>(between(stamps.first, longest->begin)).count(),
                     longest->imu_silent ? ", without IMU samples too" : "");
}

std::string hot_pixels_text(const EventHealth& events, std::uint64_t all) {
  if (!events.pixels_counted) return "not looked for";
  if (events.hot_pixels == 0) return fmt::format("none among the {} that fired", events.pixels_fired);
  std::string text = fmt::format("{} among the {} that fired, with {:.1f} % of the events:", events.hot_pixels,
                                 events.pixels_fired, 100.0 * static_cast<double>(events.hot_events) / static_cast<double>(all));
  constexpr std::size_t shown = 3;
  for (std::size_t i = 0; i < std::min(shown, events.hottest.size()); ++i) {
    text += fmt::format("{} ({}, {}) {}", i == 0 ? "" : ",", events.hottest[i].x, events.hottest[i].y,
                        rate_text(events.hottest[i].rate_hz));
  }
  return text + (events.hot_pixels > shown ? " ..." : "");
}

std::string event_lines(const StreamHealth& stream, const InfoArguments& args) {
  const EventHealth& events = *stream.events;
  const StampHealth& stamps = stream.stamps;
  Lines lines("    ");
  lines.add("polarity",
            fmt::format("{:.1f} % ON ({}), {:.1f} % OFF ({})",
                        100.0 * static_cast<double>(events.on) / static_cast<double>(stamps.elements), events.on,
                        100.0 * static_cast<double>(stamps.elements - events.on) / static_cast<double>(stamps.elements),
                        stamps.elements - events.on));
  lines.add("rate", wrapped(fmt::format("{} mean, {} in the fullest tick ({} in 2 ms)",
                                        stamps.rate_hz() ? rate_text(*stamps.rate_hz()) : "no", rate_text(events.peak_rate_hz),
                                        counted(events.peak_tick_events, "event")),
                            16));
  lines.add("read-out", !events.readout_period_us           ? "too few time stamps to tell"
                        : *events.readout_period_us <= 10.0 ? "no common period: events bear times of their own"
                                                            : fmt::format("every {:.0f} us", *events.readout_period_us));
  lines.add("silences", wrapped(gaps_text(stamps, args), 16));
  lines.add("hot pixels", wrapped(hot_pixels_text(events, stamps.elements), 16));
  return lines.text();
}

std::string text_of(const LogRows& log, const std::string& thing) {
  std::string text = counted(log.rows, thing);
  if (log.rate_hz) text += ", " + rate_text(*log.rate_hz);
  if (log.gaps > 0) text += ", " + counted(log.gaps, "gap");
  return text;
}

std::string text_of(const Report& report, const InfoArguments& args) {
  const RecordingHealth& health = report.health;
  Lines head("  ");
  if (report.run) head.add("run", text_of(*report.run));
  if (report.run && report.files.told) head.add("files", files_text(report.files, args));
  if (const StreamHealth* camera = main_stream(health)) {
    const auto& size = camera->stream.size;
    head.add("camera", fmt::format("{}, {}{}", camera->stream.source.empty() ? "not named" : camera->stream.source,
                                   size ? fmt::format("{} x {} pixels", size->width, size->height) : "no size declared",
                                   !report.run && is_simulated({&camera->stream, 1}) ? ", simulated" : ""));
  }
  if (health.first()) {
    head.add("begin", moment_text(*health.first()));
    head.add("duration", duration_text(health.duration()));
  }
  if (report.robot) head.add("robot", text_of(*report.robot, "row"));
  if (report.video) head.add("video", text_of(*report.video, "frame"));
  head.add("file", fmt::format("{}, {}, {}, data table {}", bytes_text(health.file_size), name_of(health.compression),
                               counted(health.packets(), "packet"), table_state(health)));
  std::string text = report.subject.name + "\n" + head.text() + "\n" + stream_table(health);
  for (const StreamHealth& stream : health.streams) {
    if (!stream.events || stream.stamps.elements == 0) continue;
    text += fmt::format("\n  Events of stream {}\n{}", stream.stream.id, event_lines(stream, args));
  }
  Lines verdict("  ");
  verdict.add(health.healthy() ? "healthy" : "SICK", health.healthy() ? "" : health.reasons.front());
  for (std::size_t i = 1; i < health.reasons.size(); ++i) verdict.add("", health.reasons[i]);
  for (std::size_t i = 0; i < health.notes.size(); ++i) verdict.add(i == 0 ? "notes" : "", health.notes[i]);
  std::string judged = verdict.text();
  if (health.healthy()) judged.erase(judged.find_first_of(' ', 2), judged.find('\n') - judged.find_first_of(' ', 2));
  return text + "\n" + judged;
}

void report_on(const InfoArguments& args, const CommonArguments& common) {
  const ProgressCallback progress = progress_line(common);
  Subjects subjects;
  std::vector<std::string> errors;
  nlohmann::json recordings = nlohmann::json::array();
  nlohmann::json failed = nlohmann::json::array();
  std::string text;
  bool sick = false;
  const auto attempt = [&](const std::string& name, const auto& step) {
    try {
      step();
    } catch (const std::exception& e) {
      errors.push_back(sentence_of(e, name));
      failed.push_back({{"file", name}, {"error", errors.back()}});
    }
  };
  for (const std::string& place : args.places) attempt(place, [&] { add_place(place, subjects); });
  for (const std::string& unreadable : subjects.unreadable)
    attempt(unreadable.substr(0, unreadable.find(": ")), [&] { throw Error(unreadable); });
  for (const std::string& misnamed : subjects.misnamed) spdlog::warn("{}", misnamed);
  for (const Subject& subject : subjects.found) {
    attempt(subject.name, [&] {
      const Report report = examine(subject, args, common.threads, progress);
      recordings.push_back(json_of(report, args));
      text += (text.empty() ? "" : "\n") + text_of(report, args);
      if (report.health.healthy() || !args.check) return;
      sick = true;
      for (const std::string& reason : report.health.reasons) spdlog::error("{}: {}", subject.name, reason);
    });
  }
  if (!recordings.empty() || common.json)
    print_result(common, {{"recordings", recordings}, {"failed", failed}, {"misnamed", subjects.misnamed}}, text);
  end_with(errors);
  if (sick || (args.check && !subjects.misnamed.empty())) throw CheckFailed{};
}

}  // namespace

void add_info_command(CLI::App& app) {
  auto args = std::make_shared<InfoArguments>();
  Command command = add_command(app, "info", "Show the contents of recordings: streams, rates, gaps, hot pixels, health",
                                [args](const CommonArguments& common) { report_on(*args, common); });
  command.add_option("files", args->places, "Recordings, runs, or folders of runs").type_name("FILE|RUN").required();
  command.add_option("--stream", args->stream, "Show only this event stream, given by id or source").type_name("ID|SOURCE");
  command.add_option("--gap-ms", args->gap_ms, "Report gaps without data longer than this [ms]")
      .check(in_range(std::int64_t{1}, std::int64_t{3'600'000}))
      .show_default();
  command.add_flag("--check", args->check,
                   "Check files against their SHA-256, or packets against their checksums; exit with 2 and log why if a run is "
                   "damaged or misnamed");
}

}  // namespace tactile
