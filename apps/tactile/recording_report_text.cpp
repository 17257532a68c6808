#include <fmt/core.h>

#include <algorithm>
#include <string>
#include <vector>

#include "camera_time.hpp"
#include "quantity_text.hpp"
#include "readout_text.hpp"
#include "recording_report.hpp"
#include "tactile/core/duration_units.hpp"
#include "tactile/events/simulated_recording.hpp"
#include "text_table.hpp"

namespace tactile::cli {
namespace {

/// Lines of a label and a text; the labels form a column.
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

std::string files_text(const RunFiles& files, const ReportOptions& options) {
  const std::size_t bad = files.missing.size() + files.changed.size();
  std::string text = fmt::format("{} of {} as run.json lists them, by ", files.as_listed.size(), files.as_listed.size() + bad);
  return text + (options.check ? "size and SHA-256" : "size only (--check: by SHA-256)");
}

std::string title_of(const events::Stream& stream) {
  const std::string type(name_of(stream.type));
  const std::string known = stream.type == events::StreamType::other ? type + " (" + stream.type_identifier + ")" : type;
  return fmt::format("{}  {}{}", stream.id, known, stream.name.empty() || stream.name == type ? "" : " \"" + stream.name + "\"");
}

/// The zero of the shown times. A recording without events counts from its first element.
CameraTime zero_of(const events::RecordingHealth& health, const ReportOptions& options) {
  const events::StreamHealth* events = main_stream(health);
  const bool has_events = events != nullptr && events->stamps.elements > 0;
  return zero_of_times(options.camera_time, has_events ? events->stamps.first : health.first().value_or(CameraTime{}));
}

std::string stream_table(const events::RecordingHealth& health, CameraTime zero) {
  const bool several_cameras = std::any_of(health.streams.begin(), health.streams.end(), [&](const events::StreamHealth& s) {
    return s.stream.source != health.streams.front().stream.source;
  });
  std::vector<std::string> header{"Stream", "packets", "elements", "bytes", "mean rate", "from", "to"};
  if (several_cameras) header.emplace_back("camera");
  std::vector<std::vector<std::string>> rows;
  for (const events::StreamHealth& stream : health.streams) {
    const events::StampHealth& stamps = stream.stamps;
    std::vector<std::string> row{title_of(stream.stream), std::to_string(stream.packets), std::to_string(stamps.elements),
                                 std::to_string(stream.bytes)};
    row.push_back(stamps.rate_hz() ? rate_text(*stamps.rate_hz()) : "-");
    for (const CameraTime t : {stamps.first, stamps.last}) {
      row.push_back(stamps.elements == 0 ? "-" : fmt::format("{:.6f} s", in_s(between(zero, t))));
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

std::string gaps_text(const events::StampHealth& stamps, const ReportOptions& options, CameraTime zero) {
  if (stamps.gaps == 0) return fmt::format("none longer than {} ms", options.gap_ms);
  const auto longest = std::max_element(stamps.longest_gaps.begin(), stamps.longest_gaps.end(),
                                        [](const events::Gap& a, const events::Gap& b) { return a.length() < b.length(); });
  return fmt::format("{} longer than {} ms, {} in total; the longest {} from {:.6f} s on{}", stamps.gaps, options.gap_ms,
                     duration_text(stamps.silent), duration_text(longest->length()), in_s(between(zero, longest->begin)),
                     longest->imu_silent ? ", also without IMU samples" : "");
}

std::string hot_pixels_text(const events::EventHealth& events, std::uint64_t all) {
  if (!events.pixels_counted) return "not searched";
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

std::string event_lines(const events::StreamHealth& stream, const ReportOptions& options, CameraTime zero) {
  const events::EventHealth& events = *stream.events;
  const events::StampHealth& stamps = stream.stamps;
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
  lines.add("read-out", wrapped(readout_text(events.readout), 16));
  lines.add("stamps", wrapped(precision_text(events.readout), 16));
  lines.add("silences", wrapped(gaps_text(stamps, options, zero), 16));
  lines.add("hot pixels", wrapped(hot_pixels_text(events, stamps.elements), 16));
  return lines.text();
}

std::string text_of(const LogRows& log, const std::string& thing) {
  std::string text = counted(log.rows, thing);
  if (log.rate_hz) text += ", " + rate_text(*log.rate_hz);
  if (log.gaps > 0) text += ", " + counted(log.gaps, "gap");
  return text;
}

}  // namespace

std::string text_of(const RecordingReport& report, const ReportOptions& options) {
  const events::RecordingHealth& health = report.health;
  Lines head("  ");
  if (report.run) head.add("run", text_of(*report.run));
  if (report.run && report.files.is_listed) head.add("files", files_text(report.files, options));
  if (const events::StreamHealth* camera = main_stream(health)) {
    const auto& size = camera->stream.size;
    head.add("camera", fmt::format("{}, {}{}", camera->stream.source.empty() ? "not named" : camera->stream.source,
                                   size ? fmt::format("{} x {} pixels", size->width, size->height) : "no size declared",
                                   !report.run && events::is_simulated({&camera->stream, 1}) ? ", simulated" : ""));
  }
  if (health.first()) {
    head.add("time", fmt::format("{} from {}", duration_text(health.duration()), moment_text(*health.first())));
  }
  if (report.robot) head.add("robot", text_of(*report.robot, "row"));
  if (report.video || report.has_film)
    head.add("video", report.video ? text_of(*report.video, "frame") : "a film with its own times only, without video.csv");
  const bool has_packets = health.encoding == events::RecordingEncoding::aedat4;
  head.add("file", has_packets
                       ? fmt::format("{}, {}, {}, data table {}", bytes_text(health.file_size), name_of(health.compression),
                                     counted(health.packets(), "packet"), table_state(health))
                       : fmt::format("{}, Prophesee RAW, {}", bytes_text(health.file_size), name_of(health.encoding)));
  const CameraTime zero = zero_of(health, options);
  std::string text = report.place.name + "\n" + head.text() + "\n" + stream_table(health, zero);
  for (const events::StreamHealth& stream : health.streams) {
    if (!options.verbose || !stream.events || stream.stamps.elements == 0) continue;
    text += fmt::format("\n  Events of stream {}\n{}", stream.stream.id, event_lines(stream, options, zero));
  }
  Lines verdict("  ");
  verdict.add(health.healthy() ? "healthy" : "SICK", health.healthy() ? "" : health.reasons.front());
  for (std::size_t i = 1; i < health.reasons.size(); ++i) verdict.add("", health.reasons[i]);
  for (std::size_t i = 0; i < health.notes.size(); ++i) verdict.add(i == 0 ? "notes" : "", health.notes[i]);
  std::string judged = verdict.text();
  if (health.healthy()) judged.erase(judged.find_first_of(' ', 2), judged.find('\n') - judged.find_first_of(' ', 2));
  return text + (options.verbose ? "\n" : "") + judged;
}

std::string summary_of(std::span<const RecordingReport> reports, const ReportOptions& options) {
  std::vector<std::vector<std::string>> rows;
  std::size_t healthy = 0;
  for (const RecordingReport& report : reports) {
    const events::RecordingHealth& health = report.health;
    const events::StreamHealth* events = main_stream(health);
    const bool has_events = events != nullptr && events->stamps.elements > 0;
    const auto length = has_events ? between(events->stamps.first, events->stamps.last) : microseconds{0};
    healthy += health.healthy() ? 1 : 0;
    rows.push_back({report.place.name, duration_text(length), has_events ? std::to_string(events->stamps.elements) : "0",
                    has_events && events->stamps.rate_hz() ? rate_text(*events->stamps.rate_hz()) : "-",
                    report.robot ? std::to_string(report.robot->rows) : "-",
                    report.video      ? std::to_string(report.video->rows)
                    : report.has_film ? "a film"
                                      : "-",
                    health.healthy() ? "healthy" : "SICK: " + health.reasons.front()});
  }
  return text_table({"Recording", "length", "events", "mean rate", "robot rows", "frames", ""}, rows) +
         fmt::format("{} of {} healthy{}\n", healthy, reports.size(), options.check ? "" : "; --check compares checksums too");
}

}  // namespace tactile::cli
