#include "experiment_output.hpp"

#include <spdlog/spdlog.h>

#include "tactile/results/figure_text.hpp"

namespace tactile::cli {

void log_step(const std::string& description, bool kept) {
  if (kept) {
    spdlog::debug("{}: kept", description);
  } else {
    spdlog::info("{}", description);
  }
}

void log_how_to_resume() { spdlog::warn("interrupted: the same command keeps all steps that are done, and resumes"); }

std::string figure_text(const nlohmann::json& figure, double factor, int decimals) {
  return results::figure_text(results::JsonView(figure, "figure").get<results::Figure>(), factor, decimals);
}

std::vector<std::string> draw_plots(std::span<const std::pair<std::string, pictures::Plot>> plots,
                                    const std::filesystem::path& folder) {
  std::vector<std::string> files;
  for (const auto& [name, plot] : plots) {
    for (const char* type : {".svg", ".png"}) {
      stop_if_interrupted();
      files.push_back((folder / (name + type)).string());
      pictures::draw(plot, files.back());
    }
  }
  return files;
}

}  // namespace tactile::cli
