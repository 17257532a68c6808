#include "tactile/core/confirmation.hpp"

#include <algorithm>

#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"

namespace tactile {

Confirmation confirmation_in(std::string_view text) {
  const std::size_t slash = std::min(text.find('/'), text.size());
  const auto needed = whole_number_in(text.substr(0, slash));
  const auto of = slash < text.size() ? whole_number_in(text.substr(slash + 1)) : std::nullopt;
  if (!needed || !of || *of < 1 || *of > longest_confirmation || *needed > *of || 2 * *needed <= *of) {
    throw Error("confirmation '" + std::string(text) + "'; expected k/n with n from 1 to " +
                std::to_string(longest_confirmation) + " and k more than half of n, such as 2/3");
  }
  return {static_cast<unsigned>(*needed), static_cast<unsigned>(*of)};
}

std::string text_of(const Confirmation& confirmation) {
  return std::to_string(confirmation.needed) + "/" + std::to_string(confirmation.of);
}

std::vector<Touch> confirmed(std::span<const Touch> predicted, const Confirmation& confirmation) {
  RunningConfirmation running(confirmation);
  std::vector<Touch> verdicts(predicted.size());
  std::transform(predicted.begin(), predicted.end(), verdicts.begin(), [&running](Touch touch) { return running.next(touch); });
  return verdicts;
}

Touch RunningConfirmation::next(Touch predicted) {
  --counts_[static_cast<std::size_t>(last_[oldest_])];
  ++counts_[static_cast<std::size_t>(predicted)];
  last_[oldest_] = predicted;
  if (++oldest_ == last_.size()) oldest_ = 0;
  for (const Touch touch : {Touch::press, Touch::slip}) {
    if (counts_[static_cast<std::size_t>(touch)] >= confirmation_.needed) return touch;
  }
  return Touch::none;
}

void RunningConfirmation::restart() {
  std::fill(last_.begin(), last_.end(), Touch::none);
  counts_ = {confirmation_.of, 0, 0};
}

}  // namespace tactile
