#include "tactile/capture/looped_source.hpp"

#include <algorithm>
#include <optional>
#include <utility>

namespace tactile::capture {
namespace {

class LoopedSource final : public CameraSource {
 public:
  LoopedSource(std::function<std::unique_ptr<CameraSource>()> open, microseconds gap)
      : open_(std::move(open)), gap_(gap), round_(open_()), streams_(round_->streams().begin(), round_->streams().end()) {}

  std::string name() const override { return round_->name(); }
  std::span<const events::Stream> streams() const override { return streams_; }
  bool simulated() const override { return round_->simulated(); }
  bool live() const override { return round_->live(); }
  nlohmann::json camera() const override { return round_->camera(); }
  std::string remark() const override { return round_->remark(); }
  SourceDrops drops() const override {
    SourceDrops drops = earlier_;
    return drops += round_->drops();
  }

  Received receive(CameraPacket& packet, std::chrono::microseconds patience) override {
    Received received = round_->receive(packet, patience);
    if (received == Received::ended) {
      if (!first_) return Received::ended;
      begin_next_round();
      received = round_->receive(packet, patience);
    }
    if (received == Received::packet) shift(packet);
    return received;
  }

 private:
  void begin_next_round() {
    shift_ += between(*first_, *last_) + gap_;
    first_.reset();
    last_.reset();
    earlier_ = drops();
    round_ = open_();
  }

  void note(CameraTime& t) {
    first_ = std::min(first_.value_or(t), t);
    last_ = std::max(last_.value_or(t), t);
    t = after(t, shift_);
  }

  void shift(CameraPacket& packet) {
    for (events::Event& event : packet.events) note(event.t);
    for (events::ImuSample& sample : packet.imu) note(sample.t);
    for (events::Trigger& trigger : packet.triggers) note(trigger.t);
    if (!packet.frame) return;
    events::Frame& frame = *packet.frame;
    note(frame.t);
    for (CameraTime* t : {&frame.frame_start, &frame.frame_end, &frame.exposure_start, &frame.exposure_end})
      *t = after(*t, shift_);
  }

  std::function<std::unique_ptr<CameraSource>()> open_;
  microseconds gap_;
  std::unique_ptr<CameraSource> round_;
  std::vector<events::Stream> streams_;
  std::optional<CameraTime> first_, last_;  ///< of this round, as stored
  microseconds shift_{0};                   ///< added to this round's times
  SourceDrops earlier_;                     ///< of earlier rounds
};

}  // namespace

std::unique_ptr<CameraSource> looped_source(std::function<std::unique_ptr<CameraSource>()> open, microseconds gap) {
  return std::make_unique<LoopedSource>(std::move(open), gap);
}

}  // namespace tactile::capture
