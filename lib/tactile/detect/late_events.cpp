#include "tactile/detect/late_events.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "tactile/core/duration_units.hpp"

namespace tactile::detect {
namespace {

constexpr microseconds between_reports{10'000'000}, share_window{1'000'000};

}  // namespace

std::uint64_t RepeatedFault::occurred(HostTime at) {
  const bool is_repeated = last_ && at - *last_ < between_reports;
  last_ = at;
  unreported_ = is_repeated ? unreported_ + 1 : 1;
  if (reported_ && at - *reported_ < between_reports) return 0;
  reported_ = at;
  return std::exchange(unreported_, 0);
}

bool RepeatedFault::is_due_again(HostTime at) {
  if (reported_ && at - *reported_ < between_reports) return false;
  reported_ = at;
  return true;
}

void LateEvents::add(std::span<const events::Event> events, std::size_t late, const std::optional<CameraTime>& last_reported,
                     microseconds waits, HostTime at) {
  if (late > 0 && last_reported) {
    const microseconds delay = between(events.front().t, *last_reported);
    latest_ = std::max(latest_, delay);
    needed_.add(waits + delay);
  }
  if (window_begin_ == HostTime{}) window_begin_ = at;
  window_events_ += events.size();
  window_late_ += late;
  if (at - window_begin_ < share_window) return;
  if (100 * window_late_ > window_events_ && some_late_.occurred(at) > 0) {
    const std::optional<microseconds> slack = proposed_slack();
    report_(
        {"late events",
         fmt::format("{} of {} events within {:.1f} s arrived up to {:.1f} ms after the verdict of their tick, and are left out; "
                     "expected a source that sends in time{}",
                     window_late_, window_events_, in_s(at - window_begin_), in_ms(latest_),
                     slack ? fmt::format(", or a longer slack: try --slack-us {}", slack->count()) : ""),
         at});
  }
  window_begin_ = at;
  window_events_ = window_late_ = 0;
  latest_ = {};
}

std::optional<microseconds> LateEvents::proposed_slack() const {
  constexpr microseconds longest{50'000};
  if (needed_.count() == 0) return std::nullopt;
  const microseconds slack = std::chrono::ceil<std::chrono::milliseconds>(needed_.percentile(0.99));
  return slack <= longest ? std::optional(slack) : std::nullopt;
}

std::optional<std::string> LateEvents::all_late(HostTime at) {
  if (!all_late_since_) all_late_since_ = at;
  const microseconds lasted = at - *all_late_since_;
  if (lasted < limit_) return std::nullopt;
  all_late_since_.reset();
  const std::uint64_t times = delay_grew_.occurred(at);
  if (times == 0) return std::string();
  const std::string text = fmt::format("every event came too late for {:.1f} s; ", in_s(lasted));
  if (times == 1) return text + "the stream's delay has grown, and the history starts again";
  return text + fmt::format(
                    "the stream's delay keeps growing, and the history started again {} times: the stream's time runs slower "
                    "than ours, as with a sender that is too slow, or a file served at a --speed below 1",
                    times);
}

std::string Backlog::text_of(microseconds lateness, HostTime at) {
  const std::uint64_t times = read_late_.occurred(at);
  if (times == 0) return {};
  return fmt::format(
      "events were read {:.1f} s late{}: more events arrive than can be counted here, or detect was blocked; waiting events are "
      "dropped, and the history starts again",
      in_s(lateness), times > 1 ? fmt::format(", {} times", times) : "");
}

void Backlog::dropped(bool more_came, HostTime at) {
  drops_ = more_came;
  if (drops_ && read_late_.is_due_again(at))
    report_({"behind", "more events arrive than can be read here: waiting events are dropped, and there is no verdict", at});
}

}  // namespace tactile::detect
