#include "tactile/evaluation/episodes.hpp"

namespace tactile::evaluation {

std::vector<Episode> episodes_in(std::span<const Touch> verdicts) {
  std::vector<Episode> episodes;
  for (std::size_t i = 0; i < verdicts.size(); ++i) {
    if (verdicts[i] == Touch::none) continue;
    const auto index = static_cast<std::int64_t>(i);
    if (i > 0 && verdicts[i - 1] == verdicts[i]) {
      episodes.back().last = index;
    } else {
      episodes.push_back({verdicts[i], index, index});
    }
  }
  return episodes;
}

}  // namespace tactile::evaluation
