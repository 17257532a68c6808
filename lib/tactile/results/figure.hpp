#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "tactile/results/json_view.hpp"

namespace tactile::results {

/// A value and its 95 % interval.
struct Figure {
  double value = std::numeric_limits<double>::quiet_NaN();  ///< NaN where nothing was there to measure; null in JSON
  std::optional<double> low{}, high{};  ///< nothing with fewer than three runs or objects, or with two trainings
  std::size_t n = 0;                    ///< what was drawn from: runs of one object, or objects
  std::size_t trainings = 1;            ///< that were drawn from, too; with one, its effect is not in the interval

  bool has_interval() const { return low && high; }
};

/// The value and its interval times `factor`.
Figure scaled(Figure figure, double factor);

/// "88.3 % [81.3, 94.5]"; "88.3 %" without an interval, which `note_on_intervals` explains; "unknown" where nothing was there to
/// measure.
/// @param format  of a number, as fmt takes it: "+.2f"
std::string text_of(const Figure& figure, std::string_view unit, std::string_view format = ".1f");

/// The sentence that a text with these figures says once, if one of them has a value and no interval; else nothing.
std::string note_on_intervals(std::initializer_list<Figure> figures);

/// {"value", "low", "high", "n", "trainings"}; what is not known is null.
void to_json(nlohmann::json& json, const Figure& figure);
void from_json(const JsonView& json, Figure& figure);  ///< a plain number is a value without an interval

/// A number in JSON, null where it is not finite.
nlohmann::json number_or_null(double number);

/// How intervals are drawn.
struct BootstrapOptions {
  std::size_t draws = 2000;  ///< > 0
  double confidence = 0.95;  ///< in (0, 1)
  std::uint64_t seed = 1;
};

/// {"draws", "confidence", "seed"}
void to_json(nlohmann::json& json, const BootstrapOptions& options);
void from_json(const JsonView& json, BootstrapOptions& options);

}  // namespace tactile::results
