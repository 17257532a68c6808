#include "tactile/results/delay_table.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/error_of.hpp"

namespace tactile::results {
namespace {

DelayTable table_in(const nlohmann::json& json) { return JsonView(json, "eval.json", MissingMember::is_error).get<DelayTable>(); }

TEST(DelayTable, ComesBackAsItWasWritten) {
  DelayTable table;
  table.all = {.mean_ms = {4, 3, 5, 3}, .sem_ms = 0.5, .median_ms = {.value = 4}, .intervals = 9, .misses = 1, .early = 2};
  table.objects["fan"].misses = table.objects["fan"].intervals = 1;
  const nlohmann::json json = table;
  EXPECT_TRUE(json.at("objects").at("fan").at("sem").is_null());
  const DelayTable read = table_in(json);
  EXPECT_EQ(read.all.mean_ms.high, 5);
  EXPECT_EQ(read.all.sem_ms, 0.5);
  EXPECT_EQ(read.all.median_ms.value, 4);
  EXPECT_EQ(read.all.early, 2U);
  EXPECT_EQ(read.objects.at("fan").misses, 1U);
  EXPECT_EQ(nlohmann::json(read), json);
}

TEST(DelayTable, IsRefusedByFileAndMember) {
  nlohmann::json json = DelayTable{.all = {}, .objects = {{"fan", {}}}};
  json.at("objects").at("fan").erase("early");
  EXPECT_EQ(test::error_of([&] { table_in(json); }), "eval.json: 'objects': 'fan': 'early' is missing");
  json["misses"] = -1;
  EXPECT_EQ(test::error_of([&] { table_in(json); }), "eval.json: 'misses' is number; expected a whole number from 0");
}

}  // namespace
}  // namespace tactile::results
