#include "tactile/results/claim.hpp"

#include <fmt/core.h>

#include <array>
#include <cctype>
#include <utility>

#include "tactile/core/error.hpp"

namespace tactile::results {
namespace {

constexpr std::array<std::pair<Outcome, std::string_view>, 3> names{
    {{Outcome::holds, "holds"}, {Outcome::does_not, "does not"}, {Outcome::cannot_tell, "cannot tell"}}};

}  // namespace

std::string_view name_of(Outcome outcome) { return names[static_cast<std::size_t>(outcome)].second; }

void to_json(nlohmann::json& json, Outcome outcome) { json = name_of(outcome); }

void from_json(const JsonView& json, Outcome& outcome) {
  const std::string text = json.text();
  for (const auto& [known, name] : names) {
    if (name == text) {
      outcome = known;
      return;
    }
  }
  throw Error(fmt::format("{} is '{}'; expected holds, does not or cannot tell", json.where(), text));
}

std::string words_of(const Claim& claim) {
  if (claim.replicates == 0) return "Not measured in this study.";
  const std::string limit = fmt::format("{} {:g} {}", claim.is_below ? "below" : "above", claim.limit, claim.unit);
  const std::string replicates =
      fmt::format("{} of {} replicate{}", claim.written, claim.replicates, claim.replicates == 1 ? "" : "s");
  const std::string measured = text_of(claim.measured, " " + claim.unit, ".2f");
  if (!claim.is_by_margin)
    return fmt::format("Written in {}: where {} is {}. Measured: {}.", replicates, claim.measure, limit, measured);
  std::string measure = claim.measure;
  measure.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(measure.front())));
  return fmt::format("{} must be {}, a margin; it is in {}. Measured: {}.", measure, limit, replicates, measured);
}

}  // namespace tactile::results
