#pragma once

#include <cstddef>
#include <span>

namespace tactile {

/// A measured value and its standard uncertainty: one standard deviation of what the same measurement would give again.
struct Measured {
  double value = 0;
  double uncertainty = 0;  ///< >= 0
};

/// The mean and its uncertainty, standard deviation / sqrt(n); an infinite one of fewer than two values.
Measured mean_of(std::span<const double> values);

/// A count and the measure it belongs to: events and seconds.
struct CountPart {
  double count = 0;
  double measure = 0;  ///< > 0
};

/// The ratio r of the sums, with the scatter of the parts around it:
///
///   r = sum n_i / sum t_i,   u^2 = m / (m - 1) * sum (n_i - r t_i)^2 / (sum t_i)^2
///
/// The uncertainty is infinite for fewer than two parts.
/// Source: W. G. Cochran, Sampling Techniques, 3rd edition, section 2.11.
Measured ratio_of(std::span<const CountPart> parts);

/// Independent measurements of the same value, weighted by 1 / uncertainty^2. The uncertainty grows by the scatter of the values
/// if that is larger than their uncertainties (Birge ratio). @param values  at least one
Measured combined(std::span<const Measured> values);

}  // namespace tactile
