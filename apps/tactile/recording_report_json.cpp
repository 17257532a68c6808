#include <algorithm>

#include "recording_json.hpp"
#include "recording_report.hpp"
#include "tactile/core/json.hpp"
#include "tactile/events/readout_json.hpp"

namespace tactile::cli {
namespace {

nlohmann::json json_or_null(const auto& optional) { return optional ? nlohmann::json(*optional) : nlohmann::json(); }

nlohmann::json json_of(const events::StreamHealth& stream, const ReportOptions& options) {
  const events::StampHealth& stamps = stream.stamps;
  const bool any = stamps.elements > 0;
  nlohmann::json gaps = nlohmann::json::array();
  for (const events::Gap& gap : stamps.longest_gaps) {
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
       {{"limit_us", 1000 * options.gap_ms}, {"count", stamps.gaps}, {"silent_us", stamps.silent.count()}, {"longest", gaps}}},
  };
  if (!stream.events) return json;
  const events::EventHealth& events = *stream.events;
  nlohmann::json hottest = nlohmann::json::array();
  for (const events::HotPixel& pixel : events.hottest)
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
  json["readout"] = events::json_of(events.readout);
  json["readout_period_us"] =
      events.readout.kind == events::Readout::Kind::none ? nlohmann::json() : nlohmann::json(events.readout.period_us.value);
  return json;
}

nlohmann::json json_of(const events::ChecksumHealth& checksums) {
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

}  // namespace

nlohmann::json json_of(const RecordingReport& report, const ReportOptions& options) {
  const events::RecordingHealth& health = report.health;
  nlohmann::json streams = nlohmann::json::array();
  for (const events::StreamHealth& stream : health.streams) streams.push_back(json_of(stream, options));
  const events::StreamHealth* camera = main_stream(health);
  const bool has_size = camera != nullptr && camera->stream.size.has_value();
  const events::RecordingProblems& problems = health.problems;
  nlohmann::json json = {
      {"file", health.file.string()},
      {"file_bytes", health.file_size},
      {"format", name_of(health.encoding)},
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
  json["run_files"] =
      !report.run ? nlohmann::json()
                  : nlohmann::json{{"listed", report.files.is_listed},    {"compared", options.check ? "sha256" : "bytes"},
                                   {"as_listed", report.files.as_listed}, {"missing", report.files.missing},
                                   {"changed", report.files.changed},     {"not_listed", report.files.not_listed}};
  return json;
}

}  // namespace tactile::cli
