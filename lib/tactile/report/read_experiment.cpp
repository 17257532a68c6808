#include "tactile/report/read_experiment.hpp"

#include <fmt/core.h>

#include <nlohmann/json.hpp>
#include <string_view>

#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::report {
namespace {

/// NAME.json as `tactile NAME` writes it; unlike `read_json`, of any size: many settings make it large.
template <class Result>
Result read_experiment(const std::filesystem::path& folder, std::string_view name) {
  const std::filesystem::path file = folder / fmt::format("{}.json", name);
  const auto document = nlohmann::json::parse(read_text(file), nullptr, false);
  if (document.is_discarded()) throw Error(fmt::format("{}: no JSON; expected what 'tactile {}' wrote", file.string(), name));
  return results::JsonView(document, file.string()).get<Result>();
}

}  // namespace

results::Trade read_trade(const std::filesystem::path& folder) { return read_experiment<results::Trade>(folder, "trade"); }

results::Stress read_stress(const std::filesystem::path& folder) { return read_experiment<results::Stress>(folder, "stress"); }

}  // namespace tactile::report
