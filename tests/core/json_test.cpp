#include "tactile/core/json.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"

namespace tactile {
namespace {

TEST(Json, HashDoesNotDependOnTheOrderOfKeys) {
  EXPECT_EQ(hash_of(nlohmann::json::parse(R"({"a": 1, "b": 2})")), hash_of(nlohmann::json::parse(R"({"b": 2, "a": 1})")));
  EXPECT_NE(hash_of(nlohmann::json::parse(R"({"a": 1})")), hash_of(nlohmann::json::parse(R"({"a": 2})")));
}

TEST(Json, NearestNameTakesTheFewestEdits) {
  EXPECT_EQ(nearest_name("epoch", {"batch", "epochs", "seed"}), "epochs");
  EXPECT_EQ(nearest_name("sede", {"batch", "epochs", "seed"}), "seed");
  EXPECT_EQ(nearest_name("x", {}), "");
}

TEST(Json, MemberNamesFileAndKeyWhenItIsMissingOrOfAnotherType) {
  const auto json = nlohmann::json::parse(R"({"width": "wide"})");
  for (const char* key : {"width", "height"}) {
    try {
      member<int>(json, key, "run.json");
      ADD_FAILURE() << "no error for " << key;
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find("run.json"), std::string::npos) << e.what();
      EXPECT_NE(std::string(e.what()).find(key), std::string::npos) << e.what();
    }
  }
}

TEST(Json, BrokenFileIsAnErrorThatNamesIt) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "broken.json") << "{\"a\": ";
  try {
    read_json(folder / "broken.json");
    ADD_FAILURE() << "no error";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("broken.json"), std::string::npos);
  }
}

}  // namespace
}  // namespace tactile
