#include "tactile/results/confusion.hpp"

#include <gtest/gtest.h>

#include "support/error_of.hpp"

namespace tactile::results {
namespace {

Confusion confusion_in(const std::string& text) {
  const auto json = nlohmann::json::parse(text);
  return JsonView(json, "eval.json").get<Confusion>();
}

TEST(Confusion, ComesBackAsItWasWritten) {
  const Confusion confusion{.counts = {{{90, 10, 0}, {1, 3, 0}, {0, 0, 7}}}};
  const nlohmann::json json = confusion;
  EXPECT_EQ(json.dump(), "[[90,10,0],[1,3,0],[0,0,7]]");
  EXPECT_EQ(confusion_in(json.dump()), confusion);
}

TEST(Confusion, IsRefusedWhereItIsNoTableOfCounts) {
  EXPECT_EQ(test::error_of([] { confusion_in("[[1, 2, 3], [1, 2], [1, 2, 3]]"); }),
            "eval.json does not have three rows of three counts");
  EXPECT_EQ(test::error_of([] { confusion_in("[]"); }), "eval.json does not have three rows of three counts");
  EXPECT_EQ(test::error_of([] { confusion_in("[[1, 2, 3], [1, -2, 3], [1, 2, 3]]"); }),
            "eval.json has a value that is not a whole number from 0 on");
}

}  // namespace
}  // namespace tactile::results
