#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>

#include "tactile/core/touch.hpp"
#include "tactile/results/json_view.hpp"

namespace tactile::results {

/// How often each class was predicted for each true class: rows true, columns predicted, in the order none, press, slip.
struct Confusion {
  std::array<std::array<std::uint64_t, touch_count>, touch_count> counts{};

  std::uint64_t& at(Touch truth, Touch predicted) {
    return counts[static_cast<std::size_t>(truth)][static_cast<std::size_t>(predicted)];
  }
  void add(Touch truth, Touch predicted) { ++at(truth, predicted); }
  Confusion& operator+=(const Confusion& other);
  std::uint64_t samples() const;
  std::uint64_t correct() const;           ///< on the diagonal
  std::optional<double> accuracy() const;  ///< correct / samples, in [0, 1]; nothing without samples

  friend bool operator==(const Confusion&, const Confusion&) = default;
};

/// A list of three rows of three counts.
void to_json(nlohmann::json& json, const Confusion& confusion);
void from_json(const JsonView& json, Confusion& confusion);

}  // namespace tactile::results
