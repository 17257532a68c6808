#pragma once

#include <functional>

#include "tactile/recipes/recording_clock.hpp"
#include "tactile/recipes/step.hpp"

namespace tactile::recipes {

/// The longest time that an added event waits for a read-out.
constexpr microseconds longest_readout{1'000};

/// A step that adds events between the first and the last of a recording.
///
/// An added event is read out together with the next event of the recording and gets its time, if that is at most
/// `longest_readout` later. So the recording keeps its read-outs.
class AddedEvents : public Step {
 public:
  void push(std::span<const events::Event> events, std::vector<events::Event>& out) final {
    for (const events::Event& event : events) {
      const microseconds now = clock_.advance(event.t);
      generate(now, [&](microseconds at, int x, int y, bool on) {
        const microseconds wait = now - at;
        out.push_back({wait <= longest_readout ? event.t : before(event.t, wait), static_cast<std::int16_t>(x),
                       static_cast<std::int16_t>(y), static_cast<std::uint8_t>(on ? 1 : 0)});
      });
      out.push_back(event);
    }
  }
  void finish(std::vector<events::Event>&) final {}

 protected:
  using Fire = std::function<void(microseconds at, int x, int y, bool on)>;

 private:
  /// Calls `fire` for each further event until `now`, this included, ascending in time. @param now  since the first event
  virtual void generate(microseconds now, const Fire& fire) = 0;

  RecordingClock clock_;
};

}  // namespace tactile::recipes
