#include "tactile/core/touch.hpp"

#include <string>

#include "tactile/core/error.hpp"

namespace tactile {

std::string_view name_of(Touch touch) {
  switch (touch) {
    case Touch::none:
      return "none";
    case Touch::press:
      return "press";
    case Touch::slip:
      return "slip";
  }
  return "unknown";
}

Touch touch_named(std::string_view name) {
  for (const Touch touch : all_touches) {
    if (name_of(touch) == name) return touch;
  }
  throw Error("'" + std::string(name) + "' is not a touch; expected none, press or slip");
}

}  // namespace tactile
