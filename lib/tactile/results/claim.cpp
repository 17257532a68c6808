#include "tactile/results/claim.hpp"

#include <fmt/format.h>

#include <array>

#include "tactile/core/error.hpp"

namespace tactile::results {
namespace {

/// The one of these whose name the text is; the last where there is no text.
template <class Named, std::size_t count>
Named named_in(const JsonView& json, const std::array<Named, count>& all) {
  if (!json) return all.back();
  const std::string text = json.text();
  std::string names;
  for (const Named one : all) {
    if (name_of(one) == text) return one;
    names += fmt::format("{}'{}'", names.empty() ? "" : one == all.back() ? " or " : ", ", name_of(one));
  }
  throw Error(fmt::format("{} is '{}'; expected {}", json.where(), text, names));
}

}  // namespace

std::string_view name_of(Outcome outcome) {
  switch (outcome) {
    case Outcome::holds:
      return "holds";
    case Outcome::does_not:
      return "does not";
    case Outcome::cannot_tell:
      return "cannot tell";
  }
  return "cannot tell";
}

std::string_view name_of(Asked asked) { return asked == Asked::below ? "below" : "above"; }

void to_json(nlohmann::json& json, const ClaimOutcome& result) {
  json = {{"in_words", result.in_words},
          {"measured", result.measured},
          {"objects", result.objects},
          {"kept", json_or_null(result.kept)},
          {"of", json_or_null(result.of)},
          {"verdict", name_of(result.outcome)},
          {"why", result.why},
          {"can_be_decided", result.can_be_decided},
          {"note", result.note}};
}

void to_json(nlohmann::json& json, const Claim& claim) {
  json = static_cast<const ClaimOutcome&>(claim);
  json.update({{"id", claim.id},
               {"claim", claim.claim},
               {"paper", claim.paper},
               {"unit", claim.unit},
               {"asked", name_of(claim.asked)},
               {"limit", claim.limit}});
  if (claim.all_test) json["all_test"] = *claim.all_test;
}

void from_json(const JsonView& json, ClaimOutcome& result) {
  const JsonView can_be_decided = json.renamed("can_be_decided", "can_be_told");
  result = {.measured = json["measured"].get<Figure>(),
            .objects = json["objects"].map_of<Figure>(),
            .kept = json["kept"].count_if_there(),
            .of = json["of"].count_if_there(),
            .in_words = json["in_words"].text(),
            .outcome = named_in(json["verdict"], std::array{Outcome::holds, Outcome::does_not, Outcome::cannot_tell}),
            .why = json["why"].text(),
            .can_be_decided = !can_be_decided || can_be_decided.truth(),
            .note = json["note"].text()};
}

void from_json(const JsonView& json, Claim& claim) {
  from_json(json, static_cast<ClaimOutcome&>(claim));
  claim.id = json["id"].text();
  claim.claim = json["claim"].text();
  claim.paper = json["paper"].text();
  claim.unit = json["unit"].text();
  claim.asked = named_in(json["asked"], std::array{Asked::below, Asked::above});
  claim.limit = json["limit"].number();
  claim.all_test = json["all_test"].if_there<ClaimOutcome>();
}

}  // namespace tactile::results
