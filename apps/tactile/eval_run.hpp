#pragma once

#include "command.hpp"
#include "eval_models.hpp"

namespace tactile::cli {

/// `tactile eval --run`: what a model predicts over each whole run, as CSV, PNG and SVG.
void show_runs(const EvalArguments& args, const CommonArguments& common);

}  // namespace tactile::cli
