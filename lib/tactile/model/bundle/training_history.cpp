#include "tactile/model/bundle/training_history.hpp"

#include <fmt/core.h>

#include <string_view>

#include "tactile/core/csv.hpp"
#include "tactile/core/csv_table.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::model {
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

/// The cells of a row as numbers; the two of the validation may be empty. Nothing if the row is invalid.
std::optional<std::vector<std::optional<double>>> numbers_in(const std::vector<std::string_view>& cells) {
  std::vector<std::optional<double>> numbers;
  for (const std::string_view cell : cells) {
    numbers.push_back(number_in(cell));
    const bool may_be_empty = numbers.size() == 4 || numbers.size() == 5;
    if (!numbers.back() && !(cell.empty() && may_be_empty)) return std::nullopt;
  }
  return numbers.size() == columns ? std::optional(numbers) : std::nullopt;
}

}  // namespace

std::string history_csv(const std::vector<EpochResult>& history) {
  CsvTable table(header);
  for (const EpochResult& epoch : history) {
    const auto number = [](const std::optional<double>& value) { return value ? fmt::format("{:.9g}", *value) : std::string(); };
    table.add_row(epoch.epoch, number(epoch.loss), number(epoch.accuracy), number(epoch.validation_loss),
                  number(epoch.validation_accuracy), number(epoch.learning_rate), number(epoch.gradient_norm),
                  fmt::format("{:.1f}", epoch.images_per_s), fmt::format("{:.3f}", epoch.seconds));
  }
  return table.text();
}

std::vector<EpochResult> read_history(const std::filesystem::path& file) {
  const std::string text = read_text(file);
  CsvRows rows(text);
  if (rows.row() != header)
    throw Error(fmt::format("{}: its columns are '{}'; expected '{}'", file.string(), rows.row().substr(0, 80), header));
  std::vector<EpochResult> history;
  while (rows.next()) {
    const auto cells = numbers_in(rows.cells());
    if (!cells || *cells->front() < 0 || *cells->front() > 1e9)
      throw Error(fmt::format("{}: line {} is not an epoch; expected {} numbers", file.string(), rows.line(), columns));
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

}  // namespace tactile::model
