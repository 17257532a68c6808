#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string_view>

#include "tactile/results/json_view.hpp"

namespace tactile::results {

// study.json, trade.json and stress.json each name their format, and `Result::command` is the command that writes them.

/// Reads a result. @throws Error  if it is of another format than a new one is
template <class Result>
Result experiment_in(const JsonView& json);

/// The same of a file of any size: many settings make it large. @throws Error  if it cannot be read or is no JSON, too
template <class Result>
Result read_experiment(const std::filesystem::path& file);

/// @throws Error  if the format of `json` is not `expected`, which `command` writes
void check_format(const JsonView& json, std::string_view expected, std::string_view command);

/// @throws Error  if the file, which `command` writes, cannot be read or is no JSON
nlohmann::json read_document(const std::filesystem::path& file, std::string_view command);

template <class Result>
Result experiment_in(const JsonView& json) {
  check_format(json, Result().format, Result::command);
  return json.get<Result>();
}

template <class Result>
Result read_experiment(const std::filesystem::path& file) {
  const nlohmann::json document = read_document(file, Result::command);
  return experiment_in<Result>(JsonView(document, file.string()));
}

}  // namespace tactile::results
