#pragma once

#include <cstdint>
#include <deque>
#include <nlohmann/json.hpp>
#include <span>

namespace tactile::live {

/// The last minute of some values, step by step, for a chart. Bounded: older steps are forgotten.
class Minute {
 public:
  static constexpr std::size_t most_steps = 1200;  ///< of 0.05 s

  /// @param t_s     of the step
  /// @param values  one for each column; NaN: none
  void add(double t_s, std::span<const double> values);

  std::uint64_t next() const { return first_ + rows_.size(); }  ///< the number of the step that comes next, from 0
  /// [[t, value, …], …] of the steps from this number on, as far as they are remembered; null: no value.
  nlohmann::json since(std::uint64_t number) const;

 private:
  std::deque<nlohmann::json> rows_;
  std::uint64_t first_ = 0;  ///< number of the first row
};

}  // namespace tactile::live
