#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "tactile/results/figure.hpp"
#include "tactile/results/members.hpp"

namespace tactile::results {

enum class Outcome : std::uint8_t { holds, does_not, cannot_tell };

std::string_view name_of(Outcome outcome);  ///< "holds", "does not", "cannot tell"

void to_json(nlohmann::json& json, Outcome outcome);
void from_json(const JsonView& json, Outcome& outcome);

/// A sentence of the paper, which realised one study, and in how many replicates of that study it would be written.
struct Claim {
  std::string id{};       ///< "history-2-worst"
  std::string figure{};   ///< of the paper: "8"
  std::string paper{};    ///< the sentence
  std::string measure{};  ///< what decides it in a replicate: "objects for which 2 ms is the worst history"
  std::string unit{};     ///< of `limit` and `measured`: "%", "points" (of percent), "ms", "objects"
  bool is_below = false;  ///< the sentence is written where the measure lies below `limit`; else where it lies above it
  double limit = std::numeric_limits<double>::quiet_NaN();
  bool is_by_margin = false;                ///< "comparable", "marginal": the interval decides, `limit` is its margin
  std::size_t written = 0, replicates = 0;  ///< in `written` of `replicates` the sentence would be written
  Figure measured{};                        ///< the mean over replicates
  Outcome outcome = Outcome::cannot_tell;
};

template <class Members>
void list_members(Members& members, Claim& claim) {
  members("id", claim.id);
  members("figure", claim.figure);
  members("paper", claim.paper);
  members("measure", claim.measure);
  members("unit", claim.unit);
  members("is_below", claim.is_below);
  members("limit", claim.limit);
  members("is_by_margin", claim.is_by_margin);
  members("written", claim.written);
  members("replicates", claim.replicates);
  members("measured", claim.measured);
  members("outcome", claim.outcome);
}

/// "Written in 6 of 7 replicates: where the mean delay of the slowest object is below 5 ms. Measured: 4.31 ms [3.90, 4.80]."
std::string words_of(const Claim& claim);

}  // namespace tactile::results
