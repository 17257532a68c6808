#pragma once

#include <optional>
#include <string>

#include "tactile/evaluation/tick_speed.hpp"
#include "tactile/results/evaluation.hpp"
#include "tactile/results/unseen_comparison.hpp"

namespace tactile::cli {

/// The results of an evaluation in a few lines: accuracy, best baseline, delays with misses, false alarms, wrong class. The
/// tables of `text_of` have the rest.
/// @param speed  of the model, if it was measured
std::string summary_of(const results::Evaluation& evaluation, const std::optional<evaluation::TickSpeed>& speed = {});

/// The comparison of each object, and how the models that never saw them detect.
std::string summary_of(const results::UnseenComparison& comparison, const results::Evaluation& held_out);

/// "Evaluation of th40-single-1 on simulated runs, confirmed in 2/3 ticks"
std::string heading_of(const results::Evaluation& evaluation);

}  // namespace tactile::cli
