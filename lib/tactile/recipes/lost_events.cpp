#include <fmt/core.h>

#include <algorithm>
#include <numeric>

#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"
#include "tactile/recipes/packet_clock.hpp"
#include "tactile/recipes/recording_clock.hpp"
#include "tactile/recipes/step.hpp"

namespace tactile::recipes {
namespace {

using events::Event;

/// Alternates between lost and kept times, each of exponential length.
class Bursts {
 public:
  Bursts(double share, double burst_us, std::uint64_t seed)
      : lost_us_(burst_us), kept_us_(burst_us * (1 - share) / share), random_(seed), is_lost_(random_.uniform() < share) {
    end_us_ = next_length();
  }

  bool is_lost_at(double elapsed_us) {
    while (elapsed_us >= end_us_) {
      is_lost_ = !is_lost_;
      end_us_ += next_length();
    }
    return is_lost_;
  }

 private:
  double next_length() { return (is_lost_ ? lost_us_ : kept_us_) * random_.exponential(); }

  double lost_us_, kept_us_;
  Random random_;
  bool is_lost_;
  double end_us_ = 0;
};

/// The lines that are dead: the first `count` of a random order, so that more dead lines contain fewer ones.
std::vector<bool> drawn_lines(const StepInput& input, int lines, std::string_view what) {
  if (input.recipe.severity > lines) {
    throw Error(
        fmt::format("recipe {}: {} of {} {}; expected at most all", input.recipe.name, input.recipe.severity, lines, what));
  }
  std::vector<std::size_t> order(static_cast<std::size_t>(lines));
  std::iota(order.begin(), order.end(), std::size_t{0});
  Random(input.seed).shuffle(order);
  std::vector<bool> is_dead(order.size());
  for (std::size_t i = 0; i < static_cast<std::size_t>(input.recipe.severity); ++i) is_dead[order[i]] = true;
  return is_dead;
}

}  // namespace

std::unique_ptr<Step> make_loss(const StepInput& input) {
  return event_step(
      [random = Random(input.seed), share = input.recipe.severity / 100](const Event& event, std::vector<Event>& out) mutable {
        if (random.uniform() >= share) out.push_back(event);
      });
}

std::unique_ptr<Step> make_burst_loss(const StepInput& input) {
  return event_step([bursts = Bursts(input.recipe.severity / 100, 1000 * input.parameter("burst_ms"), input.seed),
                     clock = RecordingClock()](const Event& event, std::vector<Event>& out) mutable {
    if (!bursts.is_lost_at(static_cast<double>(clock.advance(event.t).count()))) out.push_back(event);
  });
}

std::unique_ptr<Step> make_packet_loss(const StepInput& input) {
  return event_step([packets = PacketClock(input.parameter("packet_ms")), random = Random(input.seed),
                     share = input.recipe.severity / 100, is_lost = false](const Event& event, std::vector<Event>& out) mutable {
    if (packets.advance(event.t)) is_lost = random.uniform() < share;
    if (!is_lost) out.push_back(event);
  });
}

std::unique_ptr<Step> make_readout_limit(const StepInput& input) {
  const double event_us = input.recipe.severity / 1000;
  return event_step([event_us, queue_us = std::max(event_us, input.parameter("queue_us")), work_us = 0.0,
                     last = CameraTime::min()](const Event& event, std::vector<Event>& out) mutable {
    work_us = std::max(0.0, work_us - static_cast<double>(between(last, event.t).count()));
    last = event.t;
    if (work_us + event_us > queue_us * (1 + 1e-12)) return;  // a sum of many may be rounded up
    work_us += event_us;
    out.push_back(event);
  });
}

std::unique_ptr<Step> make_dead_rows(const StepInput& input) {
  return event_step([is_dead = drawn_lines(input, input.size.height, "rows")](const Event& event, std::vector<Event>& out) {
    if (!is_dead[static_cast<std::size_t>(event.y)]) out.push_back(event);
  });
}

std::unique_ptr<Step> make_dead_columns(const StepInput& input) {
  return event_step([is_dead = drawn_lines(input, input.size.width, "columns")](const Event& event, std::vector<Event>& out) {
    if (!is_dead[static_cast<std::size_t>(event.x)]) out.push_back(event);
  });
}

}  // namespace tactile::recipes
