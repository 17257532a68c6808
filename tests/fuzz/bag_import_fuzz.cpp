#include <filesystem>
#include <optional>

#include "abort_unless.hpp"
#include "bytes_as_file.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/conversion/bag_import.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/robot/robot_log.hpp"
#include "tactile/video/video_times.hpp"

namespace {

using namespace tactile;
using test::abort_unless;
namespace fs = std::filesystem;

/// The imported run can be read, and has the contents that the summary counts.
void read_back(const conversion::BagImportSummary& summary) {
  abort_unless(read_run_info(summary.run).complete ==
               (summary.problems.truncated_bytes == 0 && summary.problems.broken_chunks == 0));
  events::RecordingReader recording(summary.run.events(), 1);
  std::uint64_t events = 0, imu_samples = 0;
  CameraTime newest = CameraTime::min();
  for (const events::PacketRecord& packet : recording.packets()) {
    if (recording.stream(packet.stream_id).type == events::StreamType::imu) imu_samples += recording.read_imu(packet).size();
    if (recording.stream(packet.stream_id).type != events::StreamType::events) continue;
    for (const events::Event& event : recording.read_events(packet)) {
      abort_unless(event.t >= newest && event.x < summary.size.width && event.y < summary.size.height);
      newest = event.t;
      ++events;
    }
  }
  abort_unless(events == summary.events && imu_samples == summary.imu_samples && newest == summary.last);
  abort_unless(recording.problems().broken_packets == 0 && recording.problems().out_of_range_events == 0);
  if (summary.robot_states > 0) robot::read_robot_log(summary.run.robot());
  if (summary.frames > 0) abort_unless(video::read_video_times(summary.run.video_times()).size() == summary.frames);
}

}  // namespace

/// For any input, a run is imported that can be read, or there is an Error and no file is left.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const test::TemporaryFolder folder;
  const test::BytesAsFile bag(data, size);
  std::optional<conversion::BagImportSummary> summary;
  try {
    summary = conversion::import_bag(bag.path(), folder / "fan/01");
  } catch (const Error&) {
    abort_unless(!fs::exists(folder / "fan") || fs::is_empty(folder / "fan"));
  }
  if (summary) read_back(*summary);
  fs::remove_all(folder / "fan");
  return 0;
}
