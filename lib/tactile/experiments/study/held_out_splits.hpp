#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace tactile::study {

/// A division of the objects into those in training and those held out.
struct HeldOutSplit {
  std::string name;                   ///< "split-017": its number among all splits, from 1
  std::vector<std::string> held_out;  ///< by name
};

/// All splits with `held_out` of these objects held out, in the order of the objects' names: 252 for five of ten.
/// @throws Error  if there are not more objects than are held out, or more than a million splits
std::vector<HeldOutSplit> all_splits(std::vector<std::string> objects, std::size_t held_out);

/// `count` of them, drawn at random without replacement, in their order; all if there are no more. Splits drawn for a smaller
/// count are among those for a larger one.
std::vector<HeldOutSplit> drawn_splits(const std::vector<HeldOutSplit>& all, std::size_t count, std::uint64_t seed);

}  // namespace tactile::study
