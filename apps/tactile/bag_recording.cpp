#include "bag_recording.hpp"

#include <spdlog/spdlog.h>

#include <utility>

#include "quantity_text.hpp"
#include "tactile/core/run_folder.hpp"

namespace tactile::cli {

BagRecording::BagRecording(const std::string& bag, conversion::BagImportOptions options, const CommonArguments& common)
    : folder_(std::filesystem::temp_directory_path() / "tactile-recording") {
  options.joints_topic = options.pose_topic = options.video_topic = "none";
  summary_ = conversion::import_bag(bag, folder_.path() / "bag" / "01", options, progress_line(common));
  warn_about_import(bag, summary_);
}

void warn_about_import(const std::string& bag, const conversion::BagImportSummary& summary) {
  for (const std::string& warning : summary.warnings) spdlog::warn("{}", warning);
  const auto say = [&](std::uint64_t count, const char* what, const char* happened) {
    if (count > 0) spdlog::warn("{}: {} {}", bag, counted(count, what), happened);
  };
  const conversion::BagImportDrops& drops = summary.drops;
  say(drops.events, "event", "outside the sensor dropped");
  say(drops.late_events, "event", "too far out of order dropped");
  say(drops.event_packets, "event packet", "lost before the bag");
  say(drops.broken_messages, "message", "could not be decoded, and are not in the run");
  say(drops.other_sensor_messages, "message", "of events of a sensor of another size left out");
  say(drops.robot_states, "robot state", "dropped: no pose, not later than the previous one, or too far from it");
  say(drops.frames, "frame", "dropped: of another size, or not later than the previous one");
  say(drops.imu_samples, "IMU sample", "dropped: not later than the previous one");
  say(drops.triggers, "trigger", "dropped: earlier than the previous one");
  say(drops.unplaced_events, "event", "before the first time and row dropped");
  say(summary.problems.truncated_bytes, "byte",
      "after the last whole record: the bag is cut off, and the run has what could be read of them");
  say(summary.problems.broken_chunks, "chunk", "could not be read");
  say(summary.problems.broken_records, "record", "could not be read");
  say(summary.problems.unknown_messages, "message", "of unknown topics skipped");
}

}  // namespace tactile::cli
