#include "tactile/core/json_object.hpp"

#include <nlohmann/json.hpp>

#include "tactile/core/error.hpp"
#include "tactile/core/error_text.hpp"

namespace tactile {

void check_object(const nlohmann::json& json, std::string_view subject, std::string_view contents) {
  if (json.is_object()) return;
  throw Error(std::string(subject) + " is " + kind_in_words(json.type_name()) + "; expected an object" + std::string(contents));
}

}  // namespace tactile
