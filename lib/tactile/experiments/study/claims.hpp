#pragma once

#include <span>
#include <string>
#include <vector>

#include "tactile/core/time.hpp"
#include "tactile/results/cell.hpp"
#include "tactile/results/claim.hpp"

namespace tactile::study {

/// The sentences of the paper's section V, always the same ones in the same order. A replicate of its study is one training of
/// each setting in one world. In each it is seen whether the sentence would be written:
///
/// - history-2-worst: for all objects, 2 ms is the worst history.
/// - longer-is-better: up to 20 ms, each longer history has a higher mean accuracy over objects.
/// - best-history-40: 40 ms is the best for more objects than any other history; of equals, the shortest is the best.
/// - marginal-past-20: the highest mean accuracy past 20 ms is less than 1 point above that at 20 ms.
/// - accuracy-at-40: the accuracy of every object exceeds 95 %.
/// - press-delay, slip-delay: the mean delay of detected touches is below 5 ms for every object.
/// - slip-at-once: for more than half of the objects, every slip is detected at its first tick.
/// - right-at-first: more than 95 % of the ticks in the first 500 ms of touches are right, the mean over objects.
/// - worse-near-the-end: the share of right ticks is lower in the last 200 ms of touches than before.
/// - seen-better: the mean accuracy of held-out objects is higher with them in training.
/// - unseen-near-seen: the held-out objects but plastic-container lose less than 5 points, the mean over them.
/// - unseen-accurate: more than half of them have an accuracy above 95 %.
/// - unseen-plastic-container: that object loses at least 5 points more than any other.
///
/// **Outcome**: it holds where the sentence is written in more than half of all replicates with 95 % confidence, and does not
/// where it is in fewer: by the one-sided bounds of Clopper and Pearson on the share. "marginal" and "comparable" are of margins:
/// they hold where the 95 % interval of the measure lies within 1 point, 5 points, and do not where it lies beyond.
///
/// The paper says "highly accurate" and "comparable": 95 % is another figure of the paper, 5 points are our choice.
/// @param cells    of all settings: "th002", "th040-unseen"
/// @param main     the history of the LeNet that was judged on whole runs
/// @throws Error   if seen and unseen cells are not of the same runs
/// Source: Faris et al., arXiv:2403.10120, section V.
std::vector<results::Claim> claims_of(std::span<const results::Cell> cells, microseconds main,
                                      const results::BootstrapOptions& options = {});

/// "Of the paper's 14 sentences 4 would usually be written on simulated runs, 5 seldom; of 5 these replicates cannot tell."
std::string summary_of(std::span<const results::Claim> claims, bool simulated);

}  // namespace tactile::study
