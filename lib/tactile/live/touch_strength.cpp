#include "tactile/live/touch_strength.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "tactile/core/duration_units.hpp"
#include "tactile/core/robust_statistics.hpp"

namespace tactile::live {
namespace {

constexpr std::chrono::milliseconds window{100};
constexpr std::size_t least_windows = 10, earlier_runs = 3;
constexpr double weak_share = 0.25;

}  // namespace

void TouchStrength::begin(const std::string& run, std::uint64_t events, Time now) {
  if (!run.empty() && run == newest_of_them_) {  // it is repeated
    strengths_.pop_back();
    newest_of_them_.clear();
  }
  run_ = run;
  rates_.clear();
  counted_ = newest_ = events;
  window_ = now;
}

void TouchStrength::end() {
  if (rates_.size() < least_windows) return;
  const auto [lowest, highest] = std::minmax_element(rates_.begin(), rates_.end());
  const double strength = *highest - *lowest;
  warning_.reset();
  if (strengths_.size() >= earlier_runs) {
    const double usual = median(strengths_);
    if (strength < weak_share * usual)
      warning_ = fmt::format(
          "the touches of {} caused {:.0f} % of the events of the earlier runs: out of focus, too dark, or touched more weakly",
          run_, 100 * strength / usual);
  }
  if (warning_) return;
  strengths_.push_back(strength);
  newest_of_them_ = run_;
}

void TouchStrength::see(const std::string& run, std::uint64_t events, Time now) {
  if (run != run_ || events < newest_) {  // a run that is repeated has the same name
    if (!run_.empty()) end();
    begin(run, events, now);
    return;
  }
  newest_ = events;
  if (run.empty() || now - window_ < window) return;
  rates_.push_back(static_cast<double>(events - counted_) / in_s(now - window_));
  counted_ = events;
  window_ = now;
}

}  // namespace tactile::live
