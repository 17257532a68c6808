#include "experiment_output.hpp"

#include <fmt/core.h>
#include <spdlog/spdlog.h>

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

}  // namespace tactile::cli
