#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "tactile/results/figure.hpp"

namespace tactile::results {

enum class Outcome : std::uint8_t { holds, does_not, cannot_tell };

std::string_view name_of(Outcome outcome);  ///< "holds", "does not", "cannot tell"

enum class Asked : std::uint8_t { below, above };

std::string_view name_of(Asked asked);  ///< "below", "above"

/// What a claim is about, and what is needed to decide it.
enum class ClaimScope : std::uint8_t {
  every_object,  ///< three runs of each
  one_object,    ///< three runs of it
  over_objects,  ///< a mean, a share or a count: five objects
};

/// What was measured of a claim on one set of runs.
struct ClaimOutcome {
  Figure measured{};
  std::map<std::string, Figure> objects{};  ///< where the claim is about each object
  std::optional<std::size_t> kept{}, of{};  ///< of how many objects the claim is true by their values, and of how many measured
  std::string in_words{};  ///< the measurement as a sentence: which object decides, and for how many the claim is true
  Outcome outcome = Outcome::cannot_tell;
  std::string why{};            ///< why it cannot be decided; empty where it can
  bool can_be_decided = false;  ///< there are enough runs and objects to decide
  std::string note{};           ///< a remark, such as the number of missed intervals; may be empty
};

/// One of the paper's claims, with its measurement on the reported runs.
struct Claim : ClaimOutcome {
  std::string id;     ///< "history-2-worst"
  std::string claim;  ///< in words, with its measure
  std::string paper;  ///< what the paper says
  std::string unit;   ///< of `measured`, `limit` and `objects`: "%", "points" (of percent), "ms", "objects"
  ClaimScope scope = ClaimScope::over_objects;  ///< not in JSON
  Figure mean{};                                ///< over these very objects, where the claim is about each of them; not in JSON
  Asked asked = Asked::below;
  double limit = std::numeric_limits<double>::quiet_NaN();
  std::optional<ClaimOutcome> all_test;  ///< chosen on the reported runs themselves, as in the paper
};

/// {"id", "claim", "paper", "unit", "asked", "limit", "measured", "objects", "kept", "of", "in_words", "verdict", "why",
/// "can_be_decided", "note", "all_test"}; "all_test" has all from "measured" to "note", and is there only where it is known.
void to_json(nlohmann::json& json, const ClaimOutcome& result);
void to_json(nlohmann::json& json, const Claim& claim);
void from_json(const JsonView& json, ClaimOutcome& result);
void from_json(const JsonView& json, Claim& claim);

}  // namespace tactile::results
