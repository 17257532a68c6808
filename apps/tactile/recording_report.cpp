#include "recording_report.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <exception>

#include "quantity_text.hpp"
#include "tactile/core/error_text.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/events/simulated_recording.hpp"

namespace tactile::cli {
namespace {

/// What run.json counts as dropped; empty if nothing.
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

/// Whether run.json has the hash of the recording.
bool has_hash(const RunInfo& run, const RunFolder& folder) {
  const auto files = run.extra.find("files");
  return files != run.extra.end() && files->is_object() && files->contains(folder.events().filename().string());
}

/// Compares run.json and the run's files with the recording.
void add_run(RecordingReport& report, const ReportOptions& options, const ProgressCallback& progress) {
  const RunFolder& folder = *report.place.run;
  events::RecordingHealth& health = report.health;
  const events::SensorSize size{report.run->width, report.run->height};
  if (!report.run->complete) health.reasons.emplace_back("run.json: the run was not completed");
  for (const events::StreamHealth& stream : health.streams) {
    if (stream.events && stream.stream.size && *stream.stream.size != size) {
      health.reasons.push_back(fmt::format("run.json: the sensor has {}x{} pixels, but stream {} declares {}x{}", size.width,
                                           size.height, stream.stream.id, stream.stream.size->width, stream.stream.size->height));
    }
  }
  if (const std::string drops = drops_in(*report.run); !drops.empty())
    health.notes.push_back("run.json counts as dropped: " + drops);
  report.files = check_files(folder, *report.run, options.check ? FileComparison::contents : FileComparison::size, progress);
  health.reasons.insert(health.reasons.end(), report.files.reasons.begin(), report.files.reasons.end());
  if (!report.files.is_listed && report.run->complete) {
    health.notes.emplace_back("run.json lists no files, so that changes cannot be detected");
  } else if (report.files.is_listed && !report.files.not_listed.empty()) {
    health.notes.push_back(fmt::format("run.json does not list {}", fmt::join(report.files.not_listed, ", ")));
  }
}

}  // namespace

RecordingReport examine(const RecordingPlace& place, const ReportOptions& options, unsigned threads,
                        const ProgressCallback& progress) {
  RecordingReport report{place, {}, std::nullopt, {}, {}, {}};
  std::string no_run;
  try {
    if (place.run) {
      report.run = read_run_info(*place.run);
      report.run->simulated = events::is_simulated(*place.run);
    }
  } catch (const std::exception& e) {
    no_run = sentence_of(e);
  }
  const events::HealthOptions health_options{.stream = options.stream,
                                             .gap = std::chrono::milliseconds(options.gap_ms),
                                             .checksums = options.check && !(report.run && has_hash(*report.run, *place.run)),
                                             .threads = threads};
  report.health = events::examine_recording(place.file, health_options, progress);
  if (!place.run) return report;
  report.robot = log_rows(place.run->robot(), "timestamp", 1, 0.1);
  report.video = log_rows(place.run->video_times(), "pts_us", 1e-6, 1);
  report.has_film = is_file(place.run->video());
  if (!no_run.empty()) report.health.reasons.push_back(no_run);
  if (report.run) add_run(report, options, progress);
  return report;
}

std::string table_state(const events::RecordingHealth& health) {
  if (health.index == events::PacketIndex::table) return "used";
  if (health.index == events::PacketIndex::pieces) return "none";
  return health.problems.table.empty() ? "missing" : "unusable";
}

/// The event stream that names the camera: the first.
const events::StreamHealth* main_stream(const events::RecordingHealth& health) {
  const auto found = std::find_if(health.streams.begin(), health.streams.end(),
                                  [](const events::StreamHealth& s) { return s.events.has_value(); });
  return found == health.streams.end() ? nullptr : &*found;
}

}  // namespace tactile::cli
