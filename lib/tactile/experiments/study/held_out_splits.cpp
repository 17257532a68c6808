#include "tactile/experiments/study/held_out_splits.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <numeric>

#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"

namespace tactile::study {
namespace {

constexpr std::size_t most_splits = 1'000'000;

}  // namespace

std::vector<HeldOutSplit> all_splits(std::vector<std::string> objects, std::size_t held_out) {
  std::sort(objects.begin(), objects.end());
  objects.erase(std::unique(objects.begin(), objects.end()), objects.end());
  if (held_out == 0 || objects.size() <= held_out) {
    throw Error(fmt::format("{} objects cannot do without {} of them in training; expected {} at least", objects.size(), held_out,
                            held_out + 1));
  }
  std::vector<HeldOutSplit> splits;
  std::vector<std::size_t> chosen(held_out);
  std::iota(chosen.begin(), chosen.end(), std::size_t{0});
  while (true) {
    if (splits.size() == most_splits) throw Error("more than a million splits; expected fewer objects");
    HeldOutSplit split{fmt::format("split-{:03}", splits.size() + 1), {}};
    for (const std::size_t i : chosen) split.held_out.push_back(objects[i]);
    splits.push_back(std::move(split));
    // The last place that can still advance does, and the places after it follow directly.
    std::size_t place = held_out;
    while (place > 0 && chosen[place - 1] == objects.size() - held_out + place - 1) --place;
    if (place == 0) return splits;
    ++chosen[place - 1];
    for (std::size_t i = place; i < held_out; ++i) chosen[i] = chosen[i - 1] + 1;
  }
}

std::vector<HeldOutSplit> drawn_splits(const std::vector<HeldOutSplit>& all, std::size_t count, std::uint64_t seed) {
  std::vector<std::size_t> order(all.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  Random random(seed_for(seed, {"splits"}));
  random.shuffle(order);
  order.resize(std::min(count, order.size()));
  std::sort(order.begin(), order.end());
  std::vector<HeldOutSplit> drawn;
  for (const std::size_t i : order) drawn.push_back(all[i]);
  return drawn;
}

}  // namespace tactile::study
