#include "tactile/study/study_options.hpp"

#include <fmt/core.h>

#include "tactile/core/error.hpp"

namespace tactile {

PresetSettings preset_settings(std::string_view preset) {
  if (preset == "tiny") return {{}, 3};
  if (preset == "quick") return {{"02"}, 6};
  if (preset == "paper") return {{"02", "03"}, 10};
  throw Error(fmt::format("'{}' is no preset; expected tiny, quick or paper", preset));
}

}  // namespace tactile
