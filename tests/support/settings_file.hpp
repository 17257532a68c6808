#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "support/run_command.hpp"
#include "tactile/core/json.hpp"

namespace tactile::test {

/// Expects the settings beside a result to be those of the command that made it, and the command to have the same effective
/// settings if it runs again with them.
/// @param command  with its options; without --json
inline void expect_settings_of(const std::filesystem::path& file, const std::string& command,
                               const std::filesystem::path& folder) {
  ASSERT_TRUE(std::filesystem::exists(folder / file)) << file;
  const nlohmann::json settings = read_json(folder / file);
  const auto before = run_tactile(command + " --print-config", folder);
  ASSERT_EQ(before.exit_code, 0) << before.err;
  const nlohmann::json asked = nlohmann::json::parse(before.out);
  for (const auto& [option, value] : asked.items())
    EXPECT_EQ(settings.value(option, nlohmann::json()), value) << file << ": " << option;
  const std::string name = command.substr(0, command.find(' '));
  const auto again = run_tactile(name + " --config '" + file.string() + "' --print-config", folder);
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(nlohmann::json::parse(again.out), settings) << file;
}

}  // namespace tactile::test
