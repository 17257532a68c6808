#pragma once

#include <vector>

#include "tactile/experiments/study/claims.hpp"

namespace tactile::study {

/// The claims on histories, of figure 8; see `claims_of`.
/// @throws Error  if the histories are not of the same runs
std::vector<results::Claim> history_claims(const ClaimInputs& inputs, const results::BootstrapOptions& options);

}  // namespace tactile::study
