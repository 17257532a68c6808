#include <algorithm>
#include <cmath>
#include <deque>

#include "tactile/core/random.hpp"
#include "tactile/recipes/packet_clock.hpp"
#include "tactile/recipes/step.hpp"

namespace tactile::recipes {
namespace {

using events::Event;

/// Moves each event by a time of its own and sorts again. A displacement has a limit, so that no more events are held back than
/// come within twice that.
class Jitter final : public Step {
 public:
  Jitter(double sigma_us, std::uint64_t seed)
      : sigma_us_(sigma_us), reach_(std::llround(std::ceil(3 * sigma_us))), random_(seed) {}

  void push(std::span<const Event> events, std::vector<Event>& out) override {
    for (Event event : events) {
      release(before(event.t, reach_), out);
      event.t = after(event.t, microseconds{std::llround(sigma_us_ * std::clamp(random_.normal(), -3.0, 3.0))});
      waiting_.push_back({event, number_++});
      std::push_heap(waiting_.begin(), waiting_.end(), is_later);
    }
  }

  void finish(std::vector<Event>& out) override { release(CameraTime::max(), out); }

 private:
  struct Waiting {
    Event event;
    std::uint64_t number;  ///< events of the same time keep their order
  };
  static bool is_later(const Waiting& a, const Waiting& b) {
    return a.event.t != b.event.t ? a.event.t > b.event.t : a.number > b.number;
  }

  /// No event that is still to come is moved before `t`.
  void release(CameraTime t, std::vector<Event>& out) {
    while (!waiting_.empty() && waiting_.front().event.t <= t) {
      out.push_back(waiting_.front().event);
      std::pop_heap(waiting_.begin(), waiting_.end(), is_later);
      waiting_.pop_back();
    }
  }

  double sigma_us_;
  microseconds reach_;
  Random random_;
  std::vector<Waiting> waiting_;  ///< a heap with the earliest on top
  std::uint64_t number_ = 0;
};

/// Events of late packets get the time at which their packet arrives, so that they are missing before and present after it.
class LatePackets final : public Step {
 public:
  explicit LatePackets(const StepInput& input)
      : delay_(std::llround(1000 * input.recipe.severity)),
        share_(input.parameter("share") / 100),
        packets_(input.parameter("packet_ms")),
        random_(input.seed) {}

  void push(std::span<const Event> events, std::vector<Event>& out) override {
    for (Event event : events) {
      if (packets_.advance(event.t)) is_late_ = random_.uniform() < share_;
      release(event.t, out);
      if (is_late_) {
        event.t = after(after(event.t, packets_.until_end()), delay_);
        waiting_.push_back(event);
      } else {
        out.push_back(event);
      }
    }
  }

  void finish(std::vector<Event>& out) override { release(CameraTime::max(), out); }

 private:
  void release(CameraTime t, std::vector<Event>& out) {
    for (; !waiting_.empty() && waiting_.front().t <= t; waiting_.pop_front()) out.push_back(waiting_.front());
  }

  microseconds delay_;
  double share_;
  PacketClock packets_;
  Random random_;
  bool is_late_ = false;
  std::deque<Event> waiting_;  ///< ascending, because every packet is late by the same time
};

}  // namespace

std::unique_ptr<Step> make_jitter(const StepInput& input) { return std::make_unique<Jitter>(input.recipe.severity, input.seed); }

std::unique_ptr<Step> make_rounding(const StepInput& input) {
  return event_step([unit = std::llround(input.recipe.severity)](Event event, std::vector<Event>& out) {
    const std::int64_t rest = us_of(event.t) % unit;
    event.t = before(event.t, microseconds{rest < 0 ? rest + unit : rest});
    out.push_back(event);
  });
}

std::unique_ptr<Step> make_late(const StepInput& input) { return std::make_unique<LatePackets>(input); }

}  // namespace tactile::recipes
