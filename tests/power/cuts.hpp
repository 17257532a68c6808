#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

#include "support/folder_image.hpp"
#include "support/journal_recorder.hpp"
#include "support/paths.hpp"

namespace tactile::test {

/// Number of power cuts in a test: the environment variable TACTILE_POWER_CUTS, else `usual`.
inline std::size_t power_cuts(std::size_t usual) {
  const char* wanted = std::getenv("TACTILE_POWER_CUTS");
  return wanted == nullptr ? usual : std::stoul(wanted);
}

/// Seed of the moments and of what remains: the environment variable TACTILE_POWER_SEED, else 1.
inline std::uint64_t power_seed() {
  const char* wanted = std::getenv("TACTILE_POWER_SEED");
  return wanted == nullptr ? 1 : std::stoull(wanted);
}

/// `tactile` with arguments that contain no spaces, as words.
inline std::vector<std::string> tactile_command(const std::string& arguments) {
  std::vector<std::string> words{tactile_binary};
  std::istringstream text(arguments);
  for (std::string word; text >> word;) words.push_back(word);
  return words;
}

/// Fails unless the journal is that of a command that succeeded in `folder`, and has all its changes.
inline void expect_complete(const WrittenJournal& journal, const FolderImage& whole, const std::filesystem::path& folder) {
  EXPECT_EQ(journal.exit_code, 0);
  EXPECT_TRUE(journal.unseen.empty()) << *journal.unseen.begin();
  EXPECT_EQ(whole, image_of(folder)) << "the journal lacks a change";
}

}  // namespace tactile::test

#define REQUIRE_JOURNAL(journal) \
  if (!(journal)) GTEST_SKIP() << "this machine allows no tracing, so there is no journal"
