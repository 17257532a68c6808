#include "tactile/core/json.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"

namespace tactile {
namespace {

TEST(Json, DifferencesAreNamedByTheirMembers) {
  const auto before = nlohmann::json::parse(R"({"a": {"b": 10, "c": "x"}, "list": [1, 2], "gone": true})");
  EXPECT_EQ(differences(before, before), "");
  auto now = before;
  now["a"]["b"] = 6;
  EXPECT_EQ(differences(before, now), "a.b: 10 before, 6 now");
  now["list"] = {1, 3, 4};
  now.erase("gone");
  EXPECT_EQ(differences(before, now),
            "a.b: 10 before, 6 now; gone: true before, null now; list.1: 2 before, 3 now; list.2: null before, 4 now");
  now["a"]["c"] = "y";
  EXPECT_NE(differences(before, now).find("; and 1 more"), std::string::npos) << differences(before, now);
}

TEST(Json, HashDoesNotDependOnTheOrderOfKeys) {
  EXPECT_EQ(hash_of(nlohmann::json::parse(R"({"a": 1, "b": 2})")), hash_of(nlohmann::json::parse(R"({"b": 2, "a": 1})")));
  EXPECT_NE(hash_of(nlohmann::json::parse(R"({"a": 1})")), hash_of(nlohmann::json::parse(R"({"a": 2})")));
}

TEST(Json, NearestNameTakesTheFewestEdits) {
  EXPECT_EQ(nearest_name("epoch", {"batch", "epochs", "seed"}), "epochs");
  EXPECT_EQ(nearest_name("sede", {"batch", "epochs", "seed"}), "seed");
  EXPECT_EQ(nearest_name("x", {}), "");
  EXPECT_EQ(nearest_name("fna", {"fan", "usb-hub"}), "fan") << "two letters swapped";
  EXPECT_EQ(nearest_name("-out", {"--ticks", "--out"}), "--out") << "dashes in front do not count";
  EXPECT_EQ(nearest_name("bottle", {"fan", "water-bottle", "white-box"}), "water-bottle") << "a piece of it";
}

TEST(Json, NearestNameIsNoneWhereNoneIsNear) {
  EXPECT_EQ(nearest_name("cup", {"fan", "usb-hub", "water-bottle"}), "");
  EXPECT_EQ(nearest_name("x", {"y"}), "");
  EXPECT_EQ(nearest_name("", {"fan"}), "");
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

TEST(Json, WholeNumbersMustBeWholeAndFit) {
  const auto json = nlohmann::json::parse(R"({"a": 6.5, "b": 1e300, "c": 4294967296, "d": -1, "e": true, "f": 7})");
  for (const char* key : {"a", "b", "c", "e"}) EXPECT_THROW(member<int>(json, key, "run.json"), Error) << key;
  EXPECT_THROW(member<std::uint64_t>(json, "d", "run.json"), Error);
  EXPECT_EQ(member<std::int64_t>(json, "c", "run.json"), 4'294'967'296);
  EXPECT_EQ(member<int>(json, "d", "run.json"), -1);
  EXPECT_EQ(member<int>(json, "f", "run.json"), 7);
}

TEST(Json, NestedTooDeepIsRefusedBeforeTheStackEnds) {
  const test::TemporaryFolder folder;
  const auto write_nested = [&](std::size_t depth) {
    std::ofstream(folder / "deep.json") << "{\"text\": \"[[\\\"[\", \"a\": " << std::string(depth - 1, '[')
                                        << std::string(depth - 1, ']') << "}";
  };
  write_nested(100);
  EXPECT_NO_THROW(read_json(folder / "deep.json"));
  write_nested(101);
  EXPECT_THROW(read_json(folder / "deep.json"), Error);
  write_nested(2'000'000);
  EXPECT_THROW(read_json(folder / "deep.json"), Error);
}

TEST(Json, NamesTheLineAndWhatBelongsThere) {
  const test::TemporaryFolder folder;
  for (const auto& [text, expected] : std::vector<std::pair<std::string, std::string>>{
           {"{\n \"a\": 1,\n b: 2}", "line 3 is no JSON at 'b'; expected a name in double quotes there"},
           {"{\"a\": 1,}", "line 1 is no JSON at '}'; expected a name in double quotes there"},
           {"{\"a\" 1}", "line 1 is no JSON at '1'; expected ':' after the name there"},
           {"{\"a\": 1\n \"b\": 2}", "line 2 is no JSON at '\"b\"'; expected ',' or '}' there"},
           {"[1 2]", "line 1 is no JSON at '2'; expected ',' or ']' there"},
           {"{\"name\":\nfan}", "line 2 is no JSON at 'fan'; expected a value"},
           {"[1, ]", "line 1 is no JSON at ']'; expected a value"},
           {"[1,", "line 1 is no JSON at the end of the file; expected a value"},
           {"", "line 1 is no JSON at the end of the file; expected a value"},
           {"[1e999]", "a number is too large; expected numbers between -1.8e308 and 1.8e308"},
           {"1 2", "line 1 is no JSON at '2'; expected nothing after the value there"},
           {"{\"a\": \"b\n}", "line 1 is no JSON: a text is not closed"}}) {
    std::ofstream(folder / "bad.json") << text;
    try {
      read_json(folder / "bad.json");
      ADD_FAILURE() << text << " was taken";
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find("bad.json: " + expected), std::string::npos) << text << "\n" << e.what();
    }
  }
}

TEST(Json, NamesThatAreNoUtf8AreWrittenAllTheSame) {
  const test::TemporaryFolder folder;
  write_json(folder / "run.json", {{"source",
                                    "file:/data/b\xFC"
                                    "ro.aedat4"}});
  const nlohmann::json read = read_json(folder / "run.json");
  EXPECT_EQ(read.at("source"), "file:/data/b\xEF\xBF\xBDro.aedat4");
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
