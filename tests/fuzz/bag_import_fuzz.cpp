#include <unistd.h>

#include <filesystem>
#include <string>

#include "bytes_as_file.hpp"
#include "tactile/conversion/bag_import.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/robot/robot_log.hpp"
#include "tactile/video/video_times.hpp"

namespace {

using namespace tactile;
namespace fs = std::filesystem;

void demand(bool holds) {
  if (!holds) std::abort();
}

/// Whatever the bag was, our own readers take the run, and find in it what the summary says.
void read_back(const BagImportSummary& summary) {
  demand(read_run_info(summary.run).complete == (summary.problems.truncated_bytes == 0 && summary.problems.broken_chunks == 0));
  RecordingReader recording(summary.run.events(), 1);
  std::uint64_t events = 0, imu_samples = 0;
  CameraTime newest = CameraTime::min();
  for (const PacketRecord& packet : recording.packets()) {
    if (recording.stream(packet.stream_id).type == StreamType::imu) imu_samples += recording.read_imu(packet).size();
    if (recording.stream(packet.stream_id).type != StreamType::events) continue;
    for (const Event& event : recording.read_events(packet)) {
      demand(event.t >= newest && event.x < summary.size.width && event.y < summary.size.height);
      newest = event.t;
      ++events;
    }
  }
  demand(events == summary.events && imu_samples == summary.imu_samples && newest == summary.last);
  demand(recording.problems().broken_packets == 0 && recording.problems().out_of_range_events == 0);
  if (summary.robot_states > 0) read_robot_log(summary.run.robot());
  if (summary.frames > 0) demand(read_video_times(summary.run.video_times()).size() == summary.frames);
}

}  // namespace

/// A bag becomes a run that can be read, or an Error says why it does not and nothing of it is left.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fs::path folder = fs::temp_directory_path() / ("bag_import_fuzz_" + std::to_string(getpid()));
  const test::BytesAsFile bag(data, size);
  std::optional<BagImportSummary> summary;
  try {
    summary = import_bag(bag.path(), folder / "fan" / "01");
  } catch (const Error&) {
    demand(!fs::exists(folder / "fan") || fs::is_empty(folder / "fan"));
  }
  if (summary) read_back(*summary);
  fs::remove_all(folder);
  return 0;
}
