#include "tactile/results/json_view.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "support/error_of.hpp"

namespace tactile::results {
namespace {

TEST(JsonView, GivesWhatIsThereAndNamesWhatIsOfAnotherType) {
  const nlohmann::json json =
      nlohmann::json::parse(R"({"a": {"value": 0.5}, "b": [1, "x"], "c": null, "d": "text", "e": -1, "f": true})");
  const JsonView view(json, "eval.json");
  EXPECT_FALSE(view["c"]);
  EXPECT_FALSE(view["nothing"]["deeper"]);
  EXPECT_TRUE(std::isnan(view["nothing"]["deeper"].number()));
  EXPECT_TRUE(view["nothing"].items().empty());
  EXPECT_EQ(view["b"].words(), "1, x");
  EXPECT_EQ(view["f"].words(), "yes");
  EXPECT_EQ(view["e"].whole_number(), -1);
  EXPECT_EQ(test::error_of([&] { view["d"].number(); }), "eval.json: 'd' is string; expected a number");
  EXPECT_EQ(test::error_of([&] { view["a"]["value"].text(); }), "eval.json: 'a': 'value' is number; expected text");
  for (const auto& action :
       std::vector<std::function<void()>>{[&] { view["e"].count(); }, [&] { view["d"].items(); }, [&] { view["b"].members(); },
                                          [&] { view["d"]["x"]; }, [&] { view["b"].texts(); }, [&] { view["d"].truth(); }})
    EXPECT_NE(test::error_of(action).find("eval.json: '"), std::string::npos);
}

TEST(JsonView, RefusesToLackAMemberWhereTheFileMustBeWhole) {
  const nlohmann::json json = {{"a", {{"b", nullptr}}}};
  const JsonView whole(json, "eval.json", MissingMember::is_error);
  EXPECT_TRUE(std::isnan(whole["a"]["b"].number()));
  EXPECT_EQ(test::error_of([&] { whole["a"]["c"]; }), "eval.json: 'a': 'c' is missing");
  EXPECT_EQ(test::error_of([&] { whole["a"]["b"]["c"]; }), "eval.json: 'a': 'b': 'c' is missing");
}

}  // namespace
}  // namespace tactile::results
