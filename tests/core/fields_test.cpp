#include "tactile/core/fields.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace tactile {
namespace {

struct LowHigh {
  double low = 1;
  double high = 2;
};

struct Size {
  int width = 64;
  int height = 48;
};

struct Lens {
  double blur = 1.5;
  bool clean = true;
};

struct Camera {
  double threshold = 0.25;
  int hot_pixels = 24;
  LowHigh rate{3, 4};
  Size size;
  microseconds readout{200};
  std::string name = "mini";
  Lens lens;
  std::map<std::string, Lens> spare{{"long", {}}, {"wide", {.blur = 2.5}}};
};

template <class Fields>
void list_fields(Fields& fields, Lens& lens) {
  fields("blur", lens.blur, 0, 10);
  fields("clean", lens.clean);
}

template <class Fields>
void list_fields(Fields& fields, Camera& camera) {
  fields("threshold", camera.threshold, 1e-6, 10);
  fields("hot_pixels", camera.hot_pixels, 0, 1e12);
  fields("rate", camera.rate, 0, 100);
  fields("size", camera.size, 16, 4096);
  fields("readout_us", camera.readout, 1, 1'000'000);
  fields("name", camera.name);
  fields("lens", camera.lens);
  fields("spare", camera.spare);
}

std::string refusal(const std::string& text) {
  Camera camera;
  try {
    read_fields(nlohmann::json::parse(text), camera, "FILE");
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(Fields, ComeBackAsTheyWereWritten) {
  Camera camera{.threshold = 0.1,
                .hot_pixels = 3,
                .rate = {0, 100},
                .size = {320, 240},
                .readout = microseconds{123},
                .name = "other",
                .lens = {.blur = 1e-3, .clean = false},
                .spare = {{"long", {.blur = 7}}, {"wide", {}}}};
  const nlohmann::json json = json_of_fields(camera);
  EXPECT_EQ(json.dump(),
            R"({"hot_pixels":3,"lens":{"blur":0.001,"clean":false},"name":"other","rate":[0.0,100.0],"readout_us":123,)"
            R"("size":[320,240],"spare":{"long":{"blur":7.0,"clean":true},"wide":{"blur":1.5,"clean":true}},"threshold":0.1})");
  Camera back;
  read_fields(json, back, "FILE");
  EXPECT_EQ(json_of_fields(back), json);
}

TEST(Fields, KeepWhatIsNotGiven) {
  Camera camera;
  read_fields(nlohmann::json::parse(R"({"lens": {"blur": 3}, "spare": {"wide": {"clean": false}}})"), camera, "FILE");
  EXPECT_EQ(camera.lens.blur, 3);
  EXPECT_TRUE(camera.lens.clean);
  EXPECT_EQ(camera.spare.at("wide").blur, 2.5);
  EXPECT_FALSE(camera.spare.at("wide").clean);
  EXPECT_EQ(camera.threshold, 0.25);
}

TEST(Fields, NameTheMemberAndWhatItMayBe) {
  EXPECT_EQ(refusal(R"({"threshold": 12})"), "FILE: threshold is 12; expected 1e-06 to 10");
  EXPECT_EQ(refusal(R"({"threshold": 0})"), "FILE: threshold is 0; expected 1e-06 to 10");
  EXPECT_EQ(refusal(R"({"threshold": "low"})"), "FILE: threshold is \"low\"; expected 1e-06 to 10");
  EXPECT_EQ(refusal(R"({"threshold": null})"), "FILE: threshold is null; expected 1e-06 to 10");
  EXPECT_EQ(refusal(R"({"lens": {"blur": 11}})"), "FILE: lens.blur is 11; expected 0 to 10");
  EXPECT_EQ(refusal(R"({"lens": {"clean": 1}})"), "FILE: lens.clean is 1; expected true or false");
  EXPECT_EQ(refusal(R"({"spare": {"wide": {"blur": -1}}})"), "FILE: spare.wide.blur is -1; expected 0 to 10");
  EXPECT_EQ(refusal(R"({"name": 3})"), "FILE: name is 3; expected a text");
  EXPECT_EQ(refusal(R"({"lens": [1, 2]})"), "FILE: lens is [1,2]; expected an object of settings");
  EXPECT_EQ(refusal("[]"), "FILE: the whole is []; expected an object of settings");
}

TEST(Fields, TakeWholeNumbersRangesAndSizesForWhatTheyAre) {
  EXPECT_EQ(refusal(R"({"hot_pixels": 2.5})"), "FILE: hot_pixels is 2.5; expected a whole number from 0 to 2147483647");
  EXPECT_EQ(refusal(R"({"hot_pixels": 4000000000})"),
            "FILE: hot_pixels is 4000000000; expected a whole number from 0 to 2147483647");
  EXPECT_NE(refusal(R"({"hot_pixels": 18446744073709551615})"), "");
  EXPECT_NE(refusal(R"({"readout_us": 0})"), "");
  EXPECT_EQ(refusal(R"({"rate": [5, 4]})"), "FILE: rate is [5,4]; expected [low, high], ascending, from 0 to 100");
  for (const std::string wrong : {"[1]", "[1, 101]", "[-1, 1]", "[1, 2, 3]", "3", "[\"a\", 2]"})
    EXPECT_NE(refusal(R"({"rate": )" + wrong + "}"), "") << wrong;
  EXPECT_EQ(refusal(R"({"rate": [4, 4]})"), "");
  EXPECT_EQ(refusal(R"({"size": [8, 100]})"), "FILE: size is [8,100]; expected [width, height], whole numbers from 16 to 4096");
  for (const std::string wrong : {"[100]", "[100, 100.5]", "100", "[100, 5000]"})
    EXPECT_NE(refusal(R"({"size": )" + wrong + "}"), "") << wrong;
}

TEST(Fields, GiveTheNearestNameOfAnUnknownOne) {
  EXPECT_EQ(refusal(R"({"treshold": 1})"), "FILE: there is no 'treshold'; the nearest is 'threshold'");
  EXPECT_EQ(refusal(R"({"lens": {"blurr": 1}})"), "FILE: there is no 'lens.blurr'; the nearest is 'lens.blur'");
  EXPECT_EQ(refusal(R"({"spare": {"wile": {}}})"), "FILE: there is no 'spare.wile'; the nearest is 'spare.wide'");
}

enum class Colour : std::uint8_t { red, green };
constexpr std::array<std::string_view, 2> colour_names{"red", "green"};

/// A value that is read from its text.
struct Pair {
  int first = 1, second = 2;
};

Pair pair_named(std::string_view text) {
  if (text.size() != 3 || text[1] != ',') throw Error("'" + std::string(text) + "' is no pair; expected one such as 1,2");
  return {text[0] - '0', text[2] - '0'};
}

std::string text_of(const Pair& pair) { return std::to_string(pair.first) + "," + std::to_string(pair.second); }

struct Options {
  std::uint64_t seed = 1;
  Colour colour = Colour::red;
  Pair pair{};
  microseconds history{40'000};
  double rate = 0.001;
  unsigned steps = 3;
  double inner = 5;
};

template <class Fields>
void list_fields(Fields& fields, Options& o) {
  fields("seed", o.seed, {"seed", "Seed"});
  fields("colour", o.colour, colour_names, {"colour", "Colour"});
  fields("pair", o.pair, pair_named, {"pair", "Pair"});
  fields("history_us", o.history, 1, 100'000, {.name = "th", .meaning = "History [ms]", .us = 1000});
  fields("rate", o.rate, 1e-12, 10, {"lr", "Rate"});
  fields("steps", o.steps, 1, 100, {"steps", "Steps"});
  fields("inner", o.inner, 0, 10);
}

std::string refusal_of_options(const std::string& text) {
  try {
    Options options;
    read_all_fields(nlohmann::json::parse(text), options, "FILE");
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(Fields, OfEnumeratorsTextsAndSeedsComeBack) {
  const Options options{.seed = 18'446'744'073'709'551'615U, .colour = Colour::green, .pair = {3, 4}};
  const nlohmann::json json = json_of_fields(options);
  EXPECT_EQ(json.dump(), R"({"colour":"green","history_us":40000,"inner":5.0,"pair":"3,4","rate":0.001,)"
                         R"("seed":18446744073709551615,"steps":3})");
  Options back;
  read_all_fields(json, back, "FILE");
  EXPECT_EQ(json_of_fields(back), json);
}

TEST(Fields, OfAWholeFileAreAllThere) {
  nlohmann::json json = json_of_fields(Options{});
  EXPECT_EQ(refusal_of_options(json.dump()), "");
  json["colour"] = "blue";
  EXPECT_EQ(refusal_of_options(json.dump()), "FILE: colour is \"blue\"; expected one of red, green");
  json["colour"] = "red";
  json["seed"] = -1;
  EXPECT_EQ(refusal_of_options(json.dump()), "FILE: seed is -1; expected a whole number from 0 to 18446744073709551615");
  json["seed"] = 1;
  json["pair"] = "1";
  EXPECT_EQ(refusal_of_options(json.dump()), "'1' is no pair; expected one such as 1,2");
  json.erase("pair");
  EXPECT_EQ(refusal_of_options(json.dump()), "FILE: 'pair' is missing");
}

TEST(Fields, AreCheckedInPlace) {
  EXPECT_NO_THROW(check_fields(Options{}, "options"));
  for (const Options& wrong : {Options{.history = microseconds{0}}, Options{.rate = std::nan("")}, Options{.steps = 0}})
    EXPECT_THROW(check_fields(wrong, "options"), Error) << json_of_fields(wrong);
}

TEST(Fields, ThatDifferAreNamedAsOptions) {
  EXPECT_TRUE(options_off(Options{}).empty());
  std::string words;
  for (const OptionValue& option : options_off(Options{.seed = 2,
                                   .colour = Colour::green,
                                   .pair = {1, 3},
                                   .history = microseconds{2'500},
                                   .rate = 0.0005,
                                   .steps = 4,
                                   .inner = 6}))
    words += option.name + " " + option.text + " ";
  EXPECT_EQ(words, "--seed 2 --colour green --pair 1,3 --th 2.5 --lr 0.0005 --steps 4 ");
  EXPECT_EQ(options_off(Options{.steps = 4}, Options{.steps = 4}).size(), 0U);
}

}  // namespace
}  // namespace tactile
