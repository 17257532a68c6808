#include "tactile/model/inference/two_thresholds.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"

namespace tactile::model {
namespace {

constexpr microseconds longest_hold{10'000'000};

void check(const TwoThresholds& settings) {
  if (std::isfinite(settings.on) && std::isfinite(settings.off) && std::isfinite(settings.confirmed) &&
      settings.off <= settings.on && settings.on <= settings.confirmed && settings.hold >= microseconds{0} &&
      settings.hold <= longest_hold)
    return;
  throw Error(
      fmt::format("thresholds '{}'; expected ON:OFF:HOLD or ON:OFF:HOLD:CONFIRMED, log-odds with OFF <= ON <= CONFIRMED "
                  "and a hold from 0 to {} ms, such as {}",
                  text_of(settings), longest_hold.count() / 1000, text_of(TwoThresholds{})));
}

}  // namespace

TwoThresholds two_thresholds_in(std::string_view text) {
  std::vector<double> numbers;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(':', begin), text.size());
    numbers.push_back(number_in(text.substr(begin, end - begin)).value_or(std::numeric_limits<double>::quiet_NaN()));
    begin = end + 1;
  }
  const bool is_read = (numbers.size() == 3 || numbers.size() == 4) &&
                       std::all_of(numbers.begin(), numbers.end(), [](double n) { return std::abs(n) < 1e9; });
  if (!is_read)
    throw Error(fmt::format("thresholds '{}'; expected three or four numbers ON:OFF:HOLD:CONFIRMED, such as {}", text,
                            text_of(TwoThresholds{})));
  const TwoThresholds settings{.on = numbers[0],
                               .off = numbers[1],
                               .hold = microseconds{std::llround(1000 * numbers[2])},
                               .confirmed = numbers.size() == 4 ? numbers[3] : std::max(numbers[0], TwoThresholds{}.confirmed)};
  check(settings);
  return settings;
}

std::string text_of(const TwoThresholds& thresholds) {
  return fmt::format("{:g}:{:g}:{:g}:{:g}", thresholds.on, thresholds.off, static_cast<double>(thresholds.hold.count()) / 1000,
                     thresholds.confirmed);
}

TwoThresholds moved_to(const TwoThresholds& thresholds, double on) {
  return {.on = on,
          .off = on - (thresholds.on - thresholds.off),
          .hold = thresholds.hold,
          .confirmed = std::max(on, thresholds.confirmed)};
}

double log_odds(const Probabilities& probabilities, Touch touch) {
  constexpr double least = std::numeric_limits<float>::min();
  double others = 0;
  for (const Touch other : all_touches) {
    if (other != touch) others += static_cast<double>(probabilities[static_cast<std::size_t>(other)]);
  }
  const auto of = static_cast<double>(probabilities[static_cast<std::size_t>(touch)]);
  return std::log(std::max(of, least)) - std::log(std::max(others, least));
}

ThresholdDecision::ThresholdDecision(const TwoThresholds& settings, microseconds tick) : settings_(settings) {
  check(settings);
  if (tick <= microseconds{0}) throw Error(fmt::format("thresholds: tick of {} us; expected more than 0", tick.count()));
  hold_ticks_ = std::max<std::uint64_t>(1, static_cast<std::uint64_t>((settings.hold + tick - microseconds{1}) / tick));
}

Touch ThresholdDecision::next(const Probabilities& probabilities) {
  const double press = log_odds(probabilities, Touch::press), slip = log_odds(probabilities, Touch::slip);
  const Touch likelier = slip > press ? Touch::slip : Touch::press;
  if (reported_ != Touch::none) {
    const bool is_below = (reported_ == Touch::slip ? slip : press) < settings_.off;
    below_ = is_below ? below_ + 1 : 0;
    if (below_ >= hold_ticks_) reported_ = Touch::none;
  }
  const double needed = reported_ == Touch::none ? settings_.on : 2 * settings_.on - settings_.off;
  if (likelier != reported_ && std::max(press, slip) >= needed) {
    reported_ = likelier;
    below_ = 0;
    confirms_slip_ = false;
  }
  confirms_slip_ = reported_ == Touch::slip && (confirms_slip_ || slip >= settings_.confirmed);
  return reported_;
}

void ThresholdDecision::skip(std::uint64_t ticks) {
  if (reported_ == Touch::none || ticks == 0) return;
  below_ = ticks >= hold_ticks_ - below_ ? hold_ticks_ : below_ + ticks;
  if (below_ < hold_ticks_) return;
  reported_ = Touch::none;
  confirms_slip_ = false;
}

void ThresholdDecision::restart() {
  reported_ = Touch::none;
  confirms_slip_ = false;
  below_ = 0;
}

}  // namespace tactile::model
