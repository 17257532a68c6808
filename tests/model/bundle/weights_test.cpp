#include "tactile/model/bundle/weights.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::model {
namespace {

const std::vector<ParameterShape> shapes{{"b.weight", {2, 3}}, {"a.bias", {2}}};

Weights some_weights() { return {{shapes[0], {1, -2, 0.5F, 1e-30F, 3, 4}}, {shapes[1], {-0.0F, 7}}}; }

std::string error_of(const std::filesystem::path& file, const std::vector<ParameterShape>& expected = shapes) {
  try {
    read_weights(file, expected);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(Weights, ComeBackAsTheyWereWritten) {
  const test::TemporaryFolder folder;
  write_weights(folder / "w.safetensors", some_weights());
  EXPECT_EQ(read_weights(folder / "w.safetensors", shapes), some_weights());
}

TEST(Weights, FileIsSafetensors) {
  const test::TemporaryFolder folder;
  write_weights(folder / "w.safetensors", some_weights());
  const std::string text = read_text(folder / "w.safetensors");
  std::uint64_t length = 0;
  std::memcpy(&length, text.data(), 8);
  ASSERT_EQ(length % 8, 0U);
  ASSERT_EQ(text.size(), 8 + length + 8 * sizeof(float));
  const auto header = nlohmann::json::parse(text.substr(8, length));
  EXPECT_EQ(header.at("a.bias"), nlohmann::json::parse(R"({"dtype": "F32", "shape": [2], "data_offsets": [24, 32]})"));
  float value = 0;
  std::memcpy(&value, text.data() + 8 + length + 4, sizeof value);
  EXPECT_EQ(value, -2.0F);
}

TEST(Weights, CutOffOrLengthenedFilesAreRefused) {
  const test::TemporaryFolder folder;
  write_weights(folder / "whole", some_weights());
  const std::string text = read_text(folder / "whole");
  for (std::size_t size = 0; size < text.size(); size += 3) {
    write_whole(folder / "cut", text.substr(0, size));
    EXPECT_NE(error_of(folder / "cut"), "") << size;
  }
  write_whole(folder / "long", text + '\0');
  EXPECT_NE(error_of(folder / "long"), "");
}

TEST(Weights, OfOtherShapesOrNamesAreRefused) {
  const test::TemporaryFolder folder;
  write_weights(folder / "w", some_weights());
  EXPECT_NE(error_of(folder / "w", {{"b.weight", {3, 2}}, {"a.bias", {2}}}).find("b.weight"), std::string::npos);
  EXPECT_NE(error_of(folder / "w", {{"b.weight", {2, 3}}, {"c.bias", {2}}}).find("c.bias"), std::string::npos);
  EXPECT_NE(error_of(folder / "w", {{"b.weight", {2, 3}}}), "");
}

TEST(Weights, OfAnotherTypeAreRefusedByTheType) {
  const test::TemporaryFolder folder;
  write_weights(folder / "w", some_weights());
  std::string text = read_text(folder / "w");
  text.replace(text.find("\"F32\""), 5, "\"I32\"");
  write_whole(folder / "w", text);
  EXPECT_TRUE(error_of(folder / "w").ends_with("/w: a.bias: its values are of type 'I32'; expected F32"))
      << error_of(folder / "w");
}

TEST(Weights, WithValuesOutsideTheFileAreRefused) {
  const test::TemporaryFolder folder;
  write_weights(folder / "w", some_weights());
  std::string text = read_text(folder / "w");
  text.replace(text.find("[24,32]"), 7, "[28,36]");
  write_whole(folder / "w", text);
  EXPECT_NE(error_of(folder / "w").find("a.bias"), std::string::npos);
}

TEST(Weights, ThatAreNotFiniteAreRefused) {
  const test::TemporaryFolder folder;
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    Weights weights = some_weights();
    weights[1].values[0] = bad;
    write_weights(folder / "w", weights);
    EXPECT_NE(error_of(folder / "w").find("/w: a.bias[0] is " + std::to_string(bad)), std::string::npos);
  }
}

}  // namespace
}  // namespace tactile::model
