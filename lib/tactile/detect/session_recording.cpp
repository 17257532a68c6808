#include "tactile/detect/session_recording.hpp"

#include <fmt/core.h>

#include <thread>
#include <utility>
#include <vector>

#include "tactile/capture/new_run.hpp"
#include "tactile/core/host_clock.hpp"

namespace tactile::detect {
namespace {

constexpr int longest_wait_s = 60;  // for packets between the feed and the recorder

}  // namespace

SessionRecording::SessionRecording(const SessionRecordingOptions& options, capture::CameraSource& source, bool waits,
                                   const nlohmann::json& settings, std::function<void(const std::string&)> warn) {
  auto copy = std::make_unique<RecordedCopy>(source, waits);
  copy_ = copy.get();
  std::vector<std::unique_ptr<capture::CameraSource>> sources;
  sources.push_back(std::move(copy));
  recorder_ = std::make_unique<capture::RunRecorder>(std::move(sources), nullptr, nullptr,
                                                     capture::RunRecorderOptions{.log = std::move(warn)});
  run_ = capture::make_run_folder(options.data, options.object, options.run);
  recorder_->begin({.run = run_, .session = fmt::format("detect-{}", us_of(host_now())), .duration = {}, .settings = settings});
}

bool SessionRecording::put(const capture::CameraPacket& packet) {
  copy_->put(packet);
  return !copy_->ended_early();
}

capture::RunSummary SessionRecording::end(const std::string& why) {
  copy_->end();
  for (int i = 0; i < 100 * longest_wait_s && recorder_->state().ended.empty(); ++i) std::this_thread::sleep_for(10ms);
  return recorder_->end(copy_->ended_early() ? "the camera's clock started again" : why);
}

}  // namespace tactile::detect
