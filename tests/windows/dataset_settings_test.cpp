#include "tactile/windows/dataset_settings.hpp"

#include <gtest/gtest.h>

namespace tactile::windows {
namespace {

using namespace std::chrono_literals;

TEST(DatasetSettings, DoNotDifferFromThemselves) {
  const nlohmann::json settings = dataset_settings_of({});
  EXPECT_TRUE(differing_settings(settings, settings).empty());
}

TEST(DatasetSettings, AreListedWhereTheyDiffer) {
  const WindowsOptions before;
  WindowsOptions now;
  now.sampling.seed = 2;
  now.sampling.history = 100ms;
  now.include_flagged = true;
  const auto differing = differing_settings(dataset_settings_of(now), dataset_settings_of(before));
  EXPECT_EQ(differing, (std::vector<std::string>{"history 100 ms instead of 50 ms", "include flagged on instead of off",
                                                 "seed 2 instead of 1"}));
}

TEST(DatasetSettings, OfAManifestAreThoseAlone) {
  nlohmann::json manifest = dataset_settings_of({});
  manifest["runs"] = {"fan/01"};
  const nlohmann::json settings = dataset_settings_in(manifest);
  EXPECT_EQ(settings, dataset_settings_of({}));
  EXPECT_EQ(differing_settings(dataset_settings_of({}), nlohmann::json::object()).size(), 7U) << "what is not known differs";
}

}  // namespace
}  // namespace tactile::windows
