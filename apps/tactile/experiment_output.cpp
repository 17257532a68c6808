#include "experiment_output.hpp"

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include "command.hpp"

namespace tactile::cli {

void log_step(const std::string& description, bool kept) {
  if (kept) {
    spdlog::debug("{}: kept", description);
  } else {
    spdlog::info("{}", description);
  }
}

std::string figure_text(const nlohmann::json& figure, double factor, int decimals) {
  const auto number = [&](const char* key, const char* unknown) {
    const nlohmann::json& value = figure.at(key);
    return value.is_null() ? std::string(unknown) : fmt::format("{:.{}f}", factor * value.get<double>(), decimals);
  };
  if (figure.at("value").is_null() || (figure.at("low").is_null() && figure.at("high").is_null())) return number("value", "-");
  return fmt::format("{} [{}, {}]", number("value", "-"), number("low", "?"), number("high", "?"));
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
