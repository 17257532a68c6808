#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "command.hpp"
#include "tactile/pictures/gnuplot.hpp"

namespace tactile::cli {

/// Logs a step that begins, or, at level debug, one that is kept: the `StepCallback` of reproduce and trade.
void log_step(const std::string& description, bool kept);

void log_how_to_resume();

/// Does the steps of an experiment. @throws Interrupted  after it has logged how to resume
template <class Work>
auto resumable(Work work) {
  try {
    return work();
  } catch (const Interrupted&) {
    log_how_to_resume();
    throw;
  }
}

/// "97.31 [96.20, 98.10]", "-" without a value; an unknown bound is "?".
/// @param figure  {"value", "low", "high"}   @param factor  100 for percent
std::string figure_text(const nlohmann::json& figure, double factor, int decimals);

/// Draws each plot as NAME.svg and NAME.png in a folder. @return  the files in this order
/// @throws Interrupted  between two of them
std::vector<std::string> draw_plots(std::span<const std::pair<std::string, pictures::Plot>> plots,
                                    const std::filesystem::path& folder);

}  // namespace tactile::cli
