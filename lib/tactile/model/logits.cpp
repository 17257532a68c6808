#include "tactile/model/logits.hpp"

#include <algorithm>

namespace tactile {

Touch verdict_of(const Logits& logits) {
  return all_touches[static_cast<std::size_t>(std::max_element(logits.begin(), logits.end()) - logits.begin())];
}

}  // namespace tactile
