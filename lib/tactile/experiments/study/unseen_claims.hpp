#pragma once

#include <vector>

#include "tactile/experiments/study/claims.hpp"

namespace tactile::study {

/// The claims on objects without which a model was trained, of figure 11; see `claims_of`.
/// @throws Error  if seen and held out are not of the same runs
std::vector<results::Claim> unseen_claims(const ClaimInputs& inputs, const results::BootstrapOptions& options);

}  // namespace tactile::study
