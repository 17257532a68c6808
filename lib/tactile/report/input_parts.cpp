#include "tactile/report/input_parts.hpp"

#include <fmt/core.h>

#include <map>
#include <system_error>

#include "tactile/core/csv.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::report {

bool is_found(ReportInput& input, const std::filesystem::path& file, std::string_view what) {
  std::error_code ignored;
  if (std::filesystem::is_regular_file(file, ignored)) return true;
  input.missing.push_back(fmt::format("{}: {} does not exist.", what, file.string()));
  return false;
}

TrainingCurve training_in(const std::filesystem::path& file, const std::string& name) {
  const std::string content = read_text(file, std::size_t{16} << 20);
  CsvRows csv(content);
  if (!csv.column("epoch") || !csv.column("loss"))
    throw Error(fmt::format("{}: has no columns 'epoch' and 'loss'; expected the history of a training", file.string()));
  TrainingCurve curve{.name = name, .epochs = {}};
  while (csv.next_filled()) {
    const auto value = [&](std::string_view column) {
      return number_in(csv[column].value_or("")).value_or(std::numeric_limits<double>::quiet_NaN());
    };
    curve.epochs.push_back({.epoch = value("epoch"),
                            .loss = value("loss"),
                            .accuracy = value("accuracy"),
                            .validation_accuracy = value("validation_accuracy")});
  }
  return curve;
}

ReportedHistories histories_of(const std::string& runs, const std::vector<std::pair<double, results::Accuracy>>& accuracies) {
  ReportedHistories histories{.runs = runs, .curves = {}};
  HistoryCurve mean{.name = "mean over objects", .points = {}};
  std::map<std::string, HistoryCurve> objects;
  for (const auto& [history_ms, accuracy] : accuracies) {
    mean.points.push_back({.history_ms = history_ms, .accuracy = accuracy.mean});
    for (const auto& [object, value] : accuracy.objects) {
      objects[object].name = object;
      objects[object].points.push_back({.history_ms = history_ms, .accuracy = value});
    }
  }
  if (mean.points.empty()) return histories;
  histories.curves.push_back(std::move(mean));
  for (auto& [name, curve] : objects) histories.curves.push_back(std::move(curve));
  return histories;
}

void add_settings(std::vector<TableRow>& rows, const std::string& prefix, const results::JsonView& json) {
  for (const auto& [key, value] : json.members()) {
    if (value.is_object())
      add_settings(rows, prefix + key + " ", value);
    else
      rows.push_back({prefix + key, value ? value.words() : "-"});
  }
}

void add_sentences(std::vector<std::string>& sentences, const std::vector<std::string>& lines) {
  for (const std::string& line : lines) sentences.push_back(line.ends_with('.') ? line : line + ".");
}

std::string list_of_runs(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return names.empty() ? "none" : fmt::format("{} runs: {}", names.size(), text);
}

}  // namespace tactile::report
