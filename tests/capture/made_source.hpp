#pragma once

#include <algorithm>
#include <chrono>
#include <functional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "events/made_recording.hpp"
#include "support/comes_true.hpp"
#include "tactile/capture/camera_source.hpp"
#include "tactile/events/stream.hpp"

namespace tactile::test {

/// A camera that takes the steps of a test, on the recorder's thread.
class MadeSource : public capture::CameraSource {
 public:
  using Step = std::function<Received(capture::CameraPacket& packet, std::chrono::milliseconds patience)>;

  MadeSource(std::string name, std::vector<events::Stream> streams, Step step, bool live = true)
      : name_(std::move(name)), streams_(std::move(streams)), step_(std::move(step)), live_(live) {}

  std::string name() const override { return name_; }
  std::span<const events::Stream> streams() const override { return streams_; }
  bool live() const override { return live_; }
  nlohmann::json camera() const override { return {{"source", streams_.front().source}, {"readout_mode", "made"}}; }
  Received receive(capture::CameraPacket& packet, std::chrono::microseconds patience) override {
    return step_(packet, std::chrono::ceil<std::chrono::milliseconds>(patience));
  }
  capture::SourceDrops drops() const override { return lost; }

  static Received silent_for(std::chrono::milliseconds patience) {
    std::this_thread::sleep_for(patience);
    return Received::nothing;
  }

  capture::SourceDrops lost;

 private:
  std::string name_;
  std::vector<events::Stream> streams_;
  Step step_;
  bool live_;
};

/// The elements of `events` in packets of `size`, then silence or the end.
inline MadeSource::Step packets_of_events(std::vector<events::Event> events, std::size_t size, bool ends) {
  return [events = std::move(events), size, ends, next = std::size_t{0}](capture::CameraPacket& packet,
                                                                         std::chrono::milliseconds patience) mutable {
    if (next == events.size()) return ends ? capture::CameraSource::Received::ended : MadeSource::silent_for(patience);
    const std::size_t end = std::min(events.size(), next + size);
    packet.stream_id = 0;
    packet.events.assign(events.begin() + static_cast<std::ptrdiff_t>(next), events.begin() + static_cast<std::ptrdiff_t>(end));
    next = end;
    return capture::CameraSource::Received::packet;
  };
}

}  // namespace tactile::test
