#include "tactile/review/label_routes.hpp"

#include <gtest/gtest.h>

#include "support/error_of.hpp"

namespace tactile::review {
namespace {

using nlohmann::json;

const CameraTime first = camera_time(1'000'000);

template <class Edit>
Edit edit_of(const json& edit) {
  return std::get<Edit>(edit_in(edit, first));
}

TEST(LabelRoutes, AMoveCountsFromTheFirstEvent) {
  const auto move = edit_of<labels::MoveEnd>(
      {{"kind", "move"}, {"id", "press-1"}, {"end", "end"}, {"to_us", 250}, {"within_us", 40}, {"end_earlier", true}});
  EXPECT_EQ(move.id, "press-1");
  EXPECT_EQ(move.which, labels::IntervalEnd::end);
  EXPECT_EQ(move.to, camera_time(1'000'250));
  EXPECT_EQ(move.within, 40us);
  EXPECT_TRUE(move.end_earlier);
}

TEST(LabelRoutes, WhatAMoveLacksIsAsInTheLibrary) {
  const auto move = edit_of<labels::MoveEnd>({{"kind", "move"}, {"id", "press-1"}, {"end", "start"}, {"to_us", 0}});
  EXPECT_EQ(move.which, labels::IntervalEnd::start);
  EXPECT_EQ(move.within, labels::seen_within);
  EXPECT_FALSE(move.end_earlier);
}

TEST(LabelRoutes, EachKindIsItsEdit) {
  const auto add =
      edit_of<labels::AddInterval>({{"kind", "add"}, {"touch", "slip"}, {"start_us", 10}, {"end_us", 20}, {"within_us", 5}});
  EXPECT_EQ(add.touch, Touch::slip);
  EXPECT_EQ(add.start, camera_time(1'000'010));
  EXPECT_EQ(add.end, camera_time(1'000'020));
  EXPECT_EQ(add.within, 5us);
  EXPECT_EQ(edit_of<labels::RejectInterval>({{"kind", "reject"}, {"id", "slip-2"}}).id, "slip-2");
  EXPECT_EQ(edit_of<labels::ChangeClass>({{"kind", "class"}, {"id", "slip-2"}, {"touch", "press"}}).touch, Touch::press);
  EXPECT_EQ(edit_of<labels::ConfirmInterval>({{"kind", "confirm"}, {"id", "slip-2"}}).id, "slip-2");
  EXPECT_NO_THROW(edit_of<labels::ConfirmRun>({{"kind", "confirm-run"}}));
  EXPECT_EQ(edit_of<labels::LiftFlag>({{"kind", "lift"}, {"flag", 3}}).flag_index, 3U);
}

TEST(LabelRoutes, WhatIsNoEditIsRefusedInASentence) {
  const auto refused = [](const json& edit) {
    try {
      edit_in(edit, first);
    } catch (const Refusal& e) {
      EXPECT_EQ(e.status(), 400);
      return std::string(e.what());
    }
    return std::string("taken");
  };
  EXPECT_EQ(refused({{"kind", "paint"}}),
            "the edit: 'kind' is 'paint'; expected move, add, reject, class, confirm, confirm-run or lift");
  EXPECT_EQ(refused({{"kind", "move"}, {"id", "a"}, {"end", "middle"}, {"to_us", 0}}),
            "the edit: 'end' is 'middle'; expected start or end");
  for (const json& edit :
       {json::object(), json{{"kind", 5}}, json{{"kind", "move"}},
        json{{"kind", "move"}, {"id", 1}, {"end", "start"}, {"to_us", 0}},
        json{{"kind", "move"}, {"id", "a"}, {"end", "start"}, {"to_us", 0.5}},
        json{{"kind", "move"}, {"id", "a"}, {"end", "start"}, {"to_us", INT64_MAX}},
        json{{"kind", "move"}, {"id", "a"}, {"end", "start"}, {"to_us", 1}, {"within_us", 0}},
        json{{"kind", "add"}, {"touch", "none"}, {"start_us", 1}, {"end_us", 2}},
        json{{"kind", "add"}, {"touch", "<b>"}, {"start_us", 1}, {"end_us", 2}}, json{{"kind", "lift"}, {"flag", -1}},
        json{{"kind", "confirm"}, {"id", json::array()}}, json::array(), json(7), json()}) {
    const std::string sentence = refused(edit);
    EXPECT_TRUE(sentence.starts_with("the edit: ") || sentence.find("expected") != std::string::npos) << edit << ": " << sentence;
  }
}

}  // namespace
}  // namespace tactile::review
