#pragma once

#include <cstddef>
#include <map>
#include <string>

#include "tactile/results/claim.hpp"

namespace tactile::study {

/// Whether a figure lies below or above a limit: only if its whole interval lies on that side. Otherwise, and if
/// a bound is unknown, the result is cannot_tell.
results::Outcome below(const results::Figure& figure, double limit);
results::Outcome above(const results::Figure& figure, double limit);

/// Objects' figures, with two intervals for each.
struct ObjectFigures {
  std::map<std::string, results::Figure> objects;  ///< 95 %
  std::map<std::string, results::Figure> wide;     ///< all of them hold at once with 95 %: each has 1 - 0.05 / k for k objects
};

/// The largest (smallest) of several objects' figures, and its interval. High (low) is the largest (smallest) of the objects'
/// 95 % intervals, because all objects must lie on the claimed side. It is unknown if it is unknown for any object. Low (high)
/// is the largest (smallest) of the wide intervals, because one of many intervals may miss by chance. n = objects.
results::Figure largest_of(const ObjectFigures& figures);
results::Figure smallest_of(const ObjectFigures& figures);

inline constexpr std::size_t fewest_runs = 3, fewest_objects = 5, fewest_trainings = 5;

/// Decides a claim by its measured figure and its limit. For cannot_tell, `why` has the reason, and how many trainings,
/// runs or objects would decide at the same value. One object beyond the limit decides a claim about every object, even if the
/// others have too few runs. So does the mean over these objects: if each is on the claimed side, the mean is, too. `in_words`
/// then says so. A true claim is refuted in at most 5 % of studies: the mean's 95 % interval misses on one side in 2.5 %, and so
/// does any of the wide intervals.
void judge(results::Claim& claim);

}  // namespace tactile::study
