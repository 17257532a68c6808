#include "tactile/report/reported_stress.hpp"

#include <nlohmann/json.hpp>

#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::report {

results::Stress read_stress(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "stress.json";
  const auto document = nlohmann::json::parse(read_text(file), nullptr, false);
  if (document.is_discarded()) throw Error(file.string() + ": no JSON; expected what 'tactile stress' wrote");
  return results::JsonView(document, file.string()).get<results::Stress>();
}

}  // namespace tactile::report
