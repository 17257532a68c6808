#pragma once

#include <array>
#include <string>
#include <string_view>

#include "made_up_results.hpp"

namespace tactile::study {

constexpr std::size_t draws = 400;  // fewer than the default, for the time; the interval in use hardly depends on them
constexpr std::array<std::string_view, 3> sizes{"small", "typical", "large"};
// Typical: with another training single objects differ by up to 17 points.
constexpr std::array<Effects, 3> of_logits{{{0.1, 0.4, 0.2, 0.2, 0.1}, {0.3, 1.0, 0.5, 0.4, 0.3}, {0.6, 1.4, 1.0, 0.8, 0.5}}};
constexpr std::array<Effects, 3> of_logarithms{
    {{0.05, 0.2, 0.1, 0.1, 0.5}, {0.15, 0.5, 0.25, 0.2, 0.7}, {0.3, 0.7, 0.5, 0.4, 1.0}}};

struct Arguments {
  std::uint64_t seed = 1;
  std::size_t repeats = 800;
  unsigned threads = 0;
  std::string only;           ///< designs whose name has it; empty: all
  bool claims_alone = false;  ///< leaves the tables of coverage out

  bool takes(const Layout& layout) const { return layout.in_words().find(only) != std::string::npos; }
};

/// How often claims about each of ten objects get the wrong outcome, and the right one, by several rules; and how often the
/// intervals that the rules look at contain the true figure. Of half of the repeats.
void print_claims(const Arguments& arguments);

}  // namespace tactile::study
