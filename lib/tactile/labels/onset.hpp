#pragma once

#include <cstddef>
#include <vector>

#include "tactile/labels/activity.hpp"
#include "tactile/labels/labels.hpp"

namespace tactile {

struct OnsetOptions {
  microseconds before{40'000};  ///< searched so far before the candidate
  microseconds after{25'000};   ///< and so far behind it, > 0
  microseconds latency{1'000};  ///< a marker may have moved so long before its first event
};

/// When a burst's rate left the quiet rate, by maximum likelihood. With tau the onset, q the quiet rate and u = t - tau,
///
///   rate(t) = q for u < 0;   q + a u^p for u >= 0,   p = 0 (a blow) or p = 1 (a start from rest)
///
/// Only the bins up to where the events stand out beyond doubt are used. For each tau on the bins' edges the best a is found for
/// either p, and the larger likelihood is kept. The 95 % interval is where the log-likelihood, divided by the noise's dispersion,
/// is within 1.92 of its maximum.
///
/// @param candidate  a bin near the onset, as `bursts_in` finds it
UncertainTime onset_near(const EventRate& rate, const QuietRate& quiet, std::size_t candidate, const OnsetOptions& options = {});

}  // namespace tactile
