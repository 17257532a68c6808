#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "capture/made_source.hpp"
#include "support/comes_true.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/capture/new_run.hpp"
#include "tactile/capture/run_recorder.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile::test {

inline constexpr events::SensorSize recorder_sensor{640, 480};

inline events::Stream event_stream(const std::string& camera = "DVXplorer_DXM00001") {
  return events::event_stream_declaration(recorder_sensor, camera);
}

inline events::Stream imu_stream(std::int32_t id = 0, const std::string& camera = "DVXplorer_DXM00001") {
  return stream_of(id, events::StreamType::imu, "IMUS", camera);
}

inline std::vector<std::unique_ptr<capture::CameraSource>> sources_of(auto... sources) {
  std::vector<std::unique_ptr<capture::CameraSource>> all;
  (all.push_back(std::move(sources)), ...);
  return all;
}

inline std::unique_ptr<MadeSource> event_source(MadeSource::Step step, bool live = true) {
  return std::make_unique<MadeSource>("made:events", std::vector{event_stream()}, std::move(step), live);
}

class RunRecorderTest : public ::testing::Test {
 protected:
  /// Records until the recorder says that the run must end.
  capture::RunSummary record(capture::RunRecorder& recorder, std::optional<microseconds> duration = {}) {
    capture::RunRequest request{.run = capture::make_run_folder(data.path(), "fan"), .session = "monday", .duration = duration};
    request.settings = {{"asked", 1}};
    recorder.begin(request);
    capture::RunState state;
    EXPECT_TRUE(comes_true([&] {
      state = recorder.state();
      return !state.ended.empty();
    }));
    return recorder.end(state.ended);
  }

  TemporaryFolder data;
};

/// Noise, so that the strongest compression takes its time.
inline MadeSource::Step noise(int packets, std::atomic<std::uint64_t>& sent, int packet_events = 8192) {
  return [packets, packet_events, &sent, random = std::mt19937(1), t = std::int64_t{0}](capture::CameraPacket& packet,
                                                                                        std::chrono::milliseconds) mutable {
    if (packets-- == 0) return capture::CameraSource::Received::ended;
    packet.stream_id = 0;
    for (int i = 0; i < packet_events; ++i)
      packet.events.push_back(
          event_at(++t, static_cast<int>(random() % 640), static_cast<int>(random() % 480), static_cast<int>(random() % 2)));
    sent += packet.events.size();
    return capture::CameraSource::Received::packet;
  };
}

}  // namespace tactile::test
