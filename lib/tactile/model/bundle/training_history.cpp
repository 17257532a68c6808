#include "tactile/model/bundle/training_history.hpp"

#include <fmt/core.h>

#include <sstream>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile {
namespace {

constexpr const char* header =
    "epoch,loss,accuracy,validation_loss,validation_accuracy,learning_rate,gradient_norm,images_per_s,seconds";
constexpr std::size_t columns = 9;

nlohmann::json optional_json(const std::optional<double>& value) {
  return value ? nlohmann::json(*value) : nlohmann::json(nullptr);
}

std::optional<double> optional_number(const nlohmann::json& json, const char* key) {
  const auto value = member<nlohmann::json>(json, key, "epoch");
  return value.is_null() ? std::nullopt : std::optional(member<double>(json, key, "epoch"));
}

/// A row's cells as numbers, the two of validation perhaps empty; nothing if it is no such row.
std::optional<std::vector<std::optional<double>>> cells_of(const std::string& line) {
  std::vector<std::optional<double>> cells;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) {
    cells.push_back(number_in(cell));
    const bool may_be_empty = cells.size() == 4 || cells.size() == 5;
    if (!cells.back() && !(cell.empty() && may_be_empty)) return std::nullopt;
  }
  return cells.size() == columns ? std::optional(cells) : std::nullopt;
}

}  // namespace

std::string history_csv(const std::vector<EpochResult>& history) {
  const auto text_of = [](const std::optional<double>& value) { return value ? fmt::format("{:.9g}", *value) : std::string(); };
  std::string text = header + std::string("\n");
  for (const EpochResult& epoch : history) {
    text += fmt::format("{},{:.9g},{:.9g},{},{},{:.9g},{:.9g},{:.1f},{:.3f}\n", epoch.epoch, epoch.loss, epoch.accuracy,
                        text_of(epoch.validation_loss), text_of(epoch.validation_accuracy), epoch.learning_rate,
                        epoch.gradient_norm, epoch.images_per_s, epoch.seconds);
  }
  return text;
}

std::vector<EpochResult> read_history(const std::filesystem::path& file) {
  std::istringstream lines(read_text(file));
  std::string line;
  if (!std::getline(lines, line) || line != header)
    throw Error(fmt::format("{}: its columns are '{}'; expected '{}'", file.string(), line.substr(0, 80), header));
  std::vector<EpochResult> history;
  while (std::getline(lines, line)) {
    const auto cells = cells_of(line);
    if (!cells || *cells->front() < 0 || *cells->front() > 1e9)
      throw Error(fmt::format("{}: line {} is no epoch; expected {} numbers", file.string(), history.size() + 2, columns));
    history.push_back({.epoch = static_cast<unsigned>(*(*cells)[0]),
                       .loss = *(*cells)[1],
                       .accuracy = *(*cells)[2],
                       .validation_loss = (*cells)[3],
                       .validation_accuracy = (*cells)[4],
                       .learning_rate = *(*cells)[5],
                       .gradient_norm = *(*cells)[6],
                       .images_per_s = *(*cells)[7],
                       .seconds = *(*cells)[8]});
  }
  return history;
}

void to_json(nlohmann::json& json, const EpochResult& epoch) {
  json = {{"epoch", epoch.epoch},
          {"loss", epoch.loss},
          {"accuracy", epoch.accuracy},
          {"validation_loss", optional_json(epoch.validation_loss)},
          {"validation_accuracy", optional_json(epoch.validation_accuracy)},
          {"learning_rate", epoch.learning_rate},
          {"gradient_norm", epoch.gradient_norm},
          {"images_per_s", epoch.images_per_s},
          {"seconds", epoch.seconds}};
}

void from_json(const nlohmann::json& json, EpochResult& epoch) {
  const std::string where = "epoch";
  epoch.epoch = member<unsigned>(json, "epoch", where);
  epoch.loss = member<double>(json, "loss", where);
  epoch.accuracy = member<double>(json, "accuracy", where);
  epoch.validation_loss = optional_number(json, "validation_loss");
  epoch.validation_accuracy = optional_number(json, "validation_accuracy");
  epoch.learning_rate = member<double>(json, "learning_rate", where);
  epoch.gradient_norm = member<double>(json, "gradient_norm", where);
  epoch.images_per_s = member<double>(json, "images_per_s", where);
  epoch.seconds = member<double>(json, "seconds", where);
}

}  // namespace tactile
