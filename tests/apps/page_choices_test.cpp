// The choices of the page of `record`: which answers count. The header has all of it.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "record_choices.hpp"

namespace tactile::cli {
namespace {

const std::vector<OfferedChoice> start_or_end{{RecordChoice::start, "Start fan, run 1"}, {RecordChoice::end, "End the session"}};

TEST(PageChoices, TakeTheFirstAnswerToTheQuestionThatIsAsked) {
  PageChoices choices;
  choices.ask(start_or_end);
  const std::uint64_t first = choices.question().number;
  EXPECT_FALSE(choices.choose(first, "stop")) << "it is not offered";
  EXPECT_FALSE(choices.choose(first, "")) << "nor is nothing";
  EXPECT_FALSE(choices.chosen().has_value());
  EXPECT_FALSE(choices.was_used());
  EXPECT_TRUE(choices.choose(first, "start"));
  EXPECT_FALSE(choices.choose(first, "end")) << "it has its answer";
  EXPECT_EQ(choices.chosen(), RecordChoice::start);
  EXPECT_TRUE(choices.was_used());
}

TEST(PageChoices, AnAnswerThatComesLateAnswersNoOtherQuestion) {
  PageChoices choices;
  choices.ask(start_or_end);
  const std::uint64_t first = choices.question().number;
  ASSERT_TRUE(choices.choose(first, "end"));
  choices.ask(start_or_end);
  EXPECT_FALSE(choices.chosen().has_value()) << "what was chosen before is dropped";
  EXPECT_FALSE(choices.choose(first, "start"));
  EXPECT_EQ(choices.question().number, first + 1);
  EXPECT_TRUE(choices.choose(first + 1, "start"));
  EXPECT_TRUE(choices.was_used());
}

TEST(PageChoices, HaveNumbersThatAnEarlierProgramDidNotHave) {
  PageChoices earlier;
  for (int i = 0; i < 100; ++i) earlier.ask({});
  std::this_thread::sleep_for(std::chrono::milliseconds(2));
  PageChoices later;
  later.ask({});
  EXPECT_GT(later.question().number, earlier.question().number);
}

TEST(PageChoices, OneOfManyThreadsGivesTheAnswer) {
  PageChoices choices;
  choices.ask(start_or_end);
  const std::uint64_t asked = choices.question().number;
  std::atomic<int> taken{0};
  std::vector<std::thread> pages;
  pages.reserve(8);
  for (int i = 0; i < 8; ++i) pages.emplace_back([&] { taken += choices.choose(asked, i % 2 == 0 ? "start" : "end") ? 1 : 0; });
  for (std::thread& page : pages) page.join();
  EXPECT_EQ(taken, 1);
}

}  // namespace
}  // namespace tactile::cli
