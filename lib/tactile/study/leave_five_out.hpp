#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace tactile {

/// One way to hold some objects out of training.
struct HeldOutSplit {
  std::string name;                   ///< "split-017": its place among all, counted from 1
  std::vector<std::string> held_out;  ///< by name
};

/// Every way to hold `held_out` of these objects out, in the order of their names: 252 for five of ten.
/// @throws Error  if there are not more objects than are held out, or more than a million ways
std::vector<HeldOutSplit> all_splits(std::vector<std::string> objects, std::size_t held_out);

/// `count` of them, drawn at random without putting back, in their order; the first ones drawn for a smaller count are among
/// those for a larger one. All where there are no more.
std::vector<HeldOutSplit> drawn_splits(const std::vector<HeldOutSplit>& all, std::size_t count, std::uint64_t seed);

}  // namespace tactile
