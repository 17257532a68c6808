#pragma once

#include <span>
#include <vector>

namespace tactile::alignment {

/// The cross-correlation of two signals at every lag at which they overlap,
///
///   r[k] = sum over i of a[i] b[i + k - (a.size() - 1)],   0 <= k < a.size() + b.size() - 1
///
/// so that `k - (a.size() - 1)` is the shift of `a` against `b`. By Fourier transforms, in double precision. Empty if either is
/// empty.
std::vector<double> correlations(std::span<const double> a, std::span<const double> b);

}  // namespace tactile::alignment
