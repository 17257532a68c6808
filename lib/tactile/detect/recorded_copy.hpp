#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "tactile/capture/camera_source.hpp"
#include "tactile/capture/packet_queue.hpp"

namespace tactile::detect {

/// A source of copied packets, so that a stream can be recorded while a detector uses it. If its memory is full, it drops and
/// counts packets, or waits. It ends where the stream's time goes back, as after a restart of the camera: a recording has one
/// clock.
class RecordedCopy final : public capture::CameraSource {
 public:
  /// @param original  must outlive this, unless it is opened again; used before the first packet and after the last one
  RecordedCopy(capture::CameraSource& original, bool waits);

  void put(const capture::CameraPacket& packet);  ///< from one thread
  void end();                                     ///< after the last packet
  bool ended_early() const { return ended_early_; }

  std::string name() const override { return name_; }
  std::span<const events::Stream> streams() const override { return streams_; }
  bool simulated() const override { return simulated_; }
  bool live() const override { return live_; }
  nlohmann::json camera() const override { return camera_; }
  Received receive(capture::CameraPacket& packet, std::chrono::microseconds patience) override;
  capture::SourceDrops drops() const override;
  bool begins_again() const override { return false; }
  void begin_run(const RunFolder& run) override { original_.begin_run(run); }
  void end_run(const RunFolder& run, bool wants_robot, bool wants_video) override;

 private:
  capture::CameraSource& original_;
  const bool waits_, simulated_, live_, writes_files_;
  std::string name_;
  std::vector<events::Stream> streams_;
  nlohmann::json camera_;
  capture::PacketQueue queue_{std::size_t{256} << 20};
  std::optional<CameraTime> last_event_;
  std::atomic<bool> ended_early_{false};
  mutable std::mutex guard_;
  capture::SourceDrops lost_;
};

}  // namespace tactile::detect
