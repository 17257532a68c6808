#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <regex>
#include <string>

#include "support/paths.hpp"
#include "tactile/core/json.hpp"

namespace tactile::test {

/// Inputs of a step without what differs between machines and runs: hashes, sizes and times of files, the machine, the revision.
inline nlohmann::json lasting_inputs(const nlohmann::json& inputs) {
  static const std::regex sha256("[0-9a-f]{64}");
  if (inputs.is_string()) return std::regex_match(inputs.get<std::string>(), sha256) ? nlohmann::json("sha256") : inputs;
  if (inputs.is_array() && inputs.size() == 2 && inputs[1].is_number_integer() && std::abs(inputs[1].get<double>()) > 1e15)
    return "size and time";
  if (!inputs.is_structured()) return inputs;
  nlohmann::json lasting = inputs;
  for (auto& [key, value] : lasting.items()) value = key == "machine" || key == "revision" ? "any" : lasting_inputs(value);
  return lasting;
}

/// Expects the steps of an experiment to have the inputs that version 0.1.0 gave them: their keys follow from these, so that an
/// experiment that was interrupted then resumes now.
/// @param experiment  "study" or "trade": a member of tests/data/experiments/step_inputs.json, whose steps must all be there
inline void expect_inputs_of_first_version(const std::filesystem::path& folder, const std::string& experiment) {
  const nlohmann::json all = read_json(std::filesystem::path(data_folder) / "experiments/step_inputs.json");
  for (const auto& [name, inputs] : all.at(experiment).items()) {
    const std::filesystem::path file = folder / "steps" / (name + ".json");
    ASSERT_TRUE(std::filesystem::exists(file)) << name;
    EXPECT_EQ(lasting_inputs(read_json(file).at("inputs")), inputs) << name;
  }
}

}  // namespace tactile::test
