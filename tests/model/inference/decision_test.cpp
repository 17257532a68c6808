#include "tactile/model/inference/decision.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "support/error_of.hpp"
#include "tactile/core/random.hpp"

namespace tactile::model {
namespace {

constexpr microseconds tick{2000};

/// 100 s: none for 80 s, ten presses of 0.2 s, ten slips of 1.8 s.
Transitions usual_transitions() {
  Transitions transitions;
  transitions.counts = {{{0, 10, 10}, {10, 0, 0}, {10, 0, 0}}};
  transitions.seconds = {80, 2, 18};
  return transitions;
}

FilterSettings settings(double alarm_cost = default_alarm_cost) {
  return {.transitions = usual_transitions(), .alarm_cost = alarm_cost};
}

std::vector<Touch> filtered(const std::vector<Probabilities>& probabilities, const FilterSettings& of = settings()) {
  const std::vector<Touch> unused(probabilities.size());
  return decided({.filter = of}, tick, unused, probabilities);
}

std::vector<Probabilities> repeated(const Probabilities& probabilities, std::size_t count) { return {count, probabilities}; }

void append(std::vector<Probabilities>& to, const std::vector<Probabilities>& more) {
  to.insert(to.end(), more.begin(), more.end());
}

std::size_t episodes(const std::vector<Touch>& verdicts) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < verdicts.size(); ++i)
    count += verdicts[i] != Touch::none && (i == 0 || verdicts[i - 1] != verdicts[i]) ? 1 : 0;
  return count;
}

constexpr Probabilities quiet{0.98F, 0.01F, 0.01F}, slips{0.01F, 0.01F, 0.98F}, presses{0.01F, 0.98F, 0.01F};

TEST(Transitions, CountChangesAndTheTimeInEachClass) {
  const auto at = [](std::int64_t ms) { return CameraTime{std::chrono::milliseconds{ms}}; };
  Transitions transitions;
  const std::vector<TouchInterval> labelled{
      {Touch::press, at(100), at(300)}, {Touch::slip, at(300), at(1300)}, {Touch::press, at(1500), at(1600)}};
  transitions.add(at(0), at(2000), labelled);
  EXPECT_EQ(transitions.counts, (decltype(transitions.counts){{{0, 2, 0}, {1, 0, 1}, {1, 0, 0}}}));
  EXPECT_DOUBLE_EQ(transitions.seconds[0], 0.7);
  EXPECT_DOUBLE_EQ(transitions.seconds[1], 0.3);
  EXPECT_DOUBLE_EQ(transitions.seconds[2], 1.0);
  EXPECT_DOUBLE_EQ(transitions.rate(Touch::slip, Touch::none), 1.5 / 2);
  EXPECT_DOUBLE_EQ(Transitions{}.rate(Touch::none, Touch::slip), 0.5) << "possible although never seen";
  EXPECT_EQ(nlohmann::json(transitions).get<Transitions>(), transitions);
}

TEST(Transitions, RefuseOtherShapesAndTimes) {
  const nlohmann::json good = usual_transitions();
  for (const auto& [member, value] : {std::pair{"counts", nlohmann::json{{0, 1, 2}}},
                                      {"seconds", nlohmann::json{1, 2}},
                                      {"seconds", nlohmann::json{1, -2, 3}}}) {
    nlohmann::json wrong = good;
    wrong[member] = value;
    EXPECT_NE(test::error_of([&] { wrong.get<Transitions>(); }).find("expected 3 x 3 counts"), std::string::npos) << wrong;
  }
}

/// The formula of the header in logarithms and long double. exp(Q tick) as a power series.
std::vector<std::array<long double, 3>> reference(const std::vector<Probabilities>& probabilities, const FilterSettings& of) {
  using Row = std::array<long double, 3>;
  std::array<Row, 3> rates{}, step{}, term{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      if (i != j) rates[i][j] = of.transitions.rate(all_touches[i], all_touches[j]) * 2e-3L;
    }
    rates[i][i] = -(rates[i][0] + rates[i][1] + rates[i][2]);
    step[i][i] = term[i][i] = 1;
  }
  for (int n = 1; n < 30; ++n) {
    std::array<Row, 3> next{};
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j)
        for (std::size_t k = 0; k < 3; ++k) next[i][j] += term[i][k] * rates[k][j] / n;
    term = next;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) step[i][j] += term[i][j];
  }
  const long double weight = std::min(1.0L, 4 * 2e-3L / (static_cast<long double>(of.history.count()) * 1e-6L));
  Row logs{0, -std::numeric_limits<long double>::infinity(), -std::numeric_limits<long double>::infinity()};
  std::vector<Row> states;
  for (const Probabilities& p : probabilities) {
    Row next{};
    for (std::size_t j = 0; j < 3; ++j) {
      long double sum = 0;
      for (std::size_t i = 0; i < 3; ++i) sum += std::exp(logs[i]) * step[i][j];
      next[j] = std::log(sum) + weight * std::log(std::max<long double>(p[j], 1e-4L));
    }
    const long double total = std::log(std::exp(next[0]) + std::exp(next[1]) + std::exp(next[2]));
    for (std::size_t j = 0; j < 3; ++j) logs[j] = next[j] - total;
    states.push_back({std::exp(logs[0]), std::exp(logs[1]), std::exp(logs[2])});
  }
  return states;
}

TEST(DecisionFilter, HasTheStateOfItsFormulaInLongDouble) {
  Random random(3);
  std::vector<Probabilities> probabilities;
  for (int i = 0; i < 5000; ++i) {
    Probabilities p{};
    for (float& value : p) value = static_cast<float>(std::pow(random.uniform(0, 1), i % 7 == 0 ? 20 : 1));
    const float sum = p[0] + p[1] + p[2];
    for (float& value : p) value /= sum;
    probabilities.push_back(p);
  }
  for (const microseconds history : {microseconds{2000}, microseconds{40'000}}) {
    FilterSettings of = settings();
    of.history = history;
    const auto expected = reference(probabilities, of);
    DecisionFilter filter(of, tick);
    for (std::size_t i = 0; i < probabilities.size(); ++i) {
      filter.next(probabilities[i]);
      for (std::size_t k = 0; k < touch_count; ++k)
        ASSERT_NEAR(filter.state()[k], static_cast<double>(expected[i][k]), 1e-12 + 1e-9 * static_cast<double>(expected[i][k]))
            << i;
    }
  }
}

TEST(DecisionFilter, ReportsASlipOnceAlthoughItsPredictionsFlicker) {
  std::vector<Probabilities> probabilities = repeated(quiet, 200);
  for (int i = 0; i < 20; ++i) {
    append(probabilities, repeated(slips, 12));
    append(probabilities, repeated(quiet, 3));
    append(probabilities, repeated(presses, 2));
  }
  append(probabilities, repeated(quiet, 200));
  const std::vector<Touch> verdicts = filtered(probabilities);
  EXPECT_EQ(episodes(verdicts), 1U);
  EXPECT_EQ(verdicts[210], Touch::slip);
  EXPECT_EQ(verdicts.back(), Touch::none);
}

TEST(DecisionFilter, DoesNotReportASingleTick) {
  std::vector<Probabilities> probabilities = repeated(quiet, 200);
  append(probabilities, {slips});
  append(probabilities, repeated(quiet, 200));
  EXPECT_EQ(episodes(filtered(probabilities)), 0U);
}

TEST(DecisionFilter, ReportsLaterTheMoreAnAlarmCosts) {
  std::vector<Probabilities> probabilities = repeated(quiet, 200);
  append(probabilities, repeated(slips, 100));
  std::ptrdiff_t before = 0;
  for (const double alarm_cost : {0.01, 0.1, 1.0, 10.0}) {
    const std::vector<Touch> verdicts = filtered(probabilities, settings(alarm_cost));
    const std::ptrdiff_t first = std::find(verdicts.begin(), verdicts.end(), Touch::slip) - verdicts.begin();
    EXPECT_GT(first, before) << alarm_cost;
    EXPECT_LT(first, 260) << alarm_cost;
    before = first;
  }
}

TEST(DecisionFilter, ChangesToTheOtherClassOnceThatIsFarLikelier) {
  std::vector<Probabilities> probabilities = repeated(quiet, 100);
  append(probabilities, repeated(presses, 100));
  append(probabilities, repeated(slips, 100));
  const std::vector<Touch> verdicts = filtered(probabilities);
  EXPECT_EQ(episodes(verdicts), 2U);
  EXPECT_EQ(verdicts[199], Touch::press);
  EXPECT_EQ(verdicts[299], Touch::slip);
}

TEST(DecisionFilter, SkipsTicksAsIfNothingWereObserved) {
  DecisionFilter once(settings(), tick), each(settings(), tick);
  for (DecisionFilter* filter : {&once, &each}) {
    for (int i = 0; i < 50; ++i) filter->next(slips);
  }
  once.skip(1003);
  for (int i = 0; i < 1003; ++i) each.skip(1);
  for (std::size_t k = 0; k < touch_count; ++k) EXPECT_NEAR(once.state()[k], each.state()[k], 1e-12);
  // After ages only the rates count: the shares of time in each class.
  once.skip(1'000'000'000'000);
  const double press = usual_transitions().rate(Touch::none, Touch::press) / usual_transitions().rate(Touch::press, Touch::none);
  EXPECT_NEAR(once.state()[1] / once.state()[0], press, 0.25 * press);
  EXPECT_NEAR(once.state()[0] + once.state()[1] + once.state()[2], 1, 1e-9);
}

TEST(DecisionFilter, RestartsInNone) {
  DecisionFilter filter(settings(), tick);
  for (int i = 0; i < 50; ++i) filter.next(slips);
  filter.restart();
  EXPECT_EQ(filter.next(quiet), Touch::none);
}

TEST(DecisionFilter, StaysFiniteAtTheExtremes) {
  Transitions fast, slow;
  fast.counts = {{{0, 1'000'000'000, 1'000'000'000}, {1'000'000'000, 0, 0}, {1'000'000'000, 0, 0}}};
  slow.seconds = {1e12, 1e12, 1e12};
  for (const Transitions& transitions : {fast, slow, Transitions{}}) {
    for (const microseconds step : {microseconds{1}, microseconds{10'000'000}}) {
      for (const double alarm_cost : {1e-6, 1e6}) {
        DecisionFilter filter({.transitions = transitions, .alarm_cost = alarm_cost}, step);
        for (int i = 0; i < 20'000; ++i) {
          filter.next(i / 5000 % 2 == 0 ? Probabilities{1, 0, 0} : Probabilities{0, 0, 1});
          if (i % 1000 == 0) filter.skip(std::numeric_limits<std::uint64_t>::max());
          const auto& state = filter.state();
          ASSERT_NEAR(state[0] + state[1] + state[2], 1, 1e-9);
          for (const double value : state) ASSERT_GE(value, 0);
        }
      }
    }
  }
}

TEST(DecisionFilter, RefusesSettingsOutOfTheirRange) {
  for (const double alarm_cost : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    EXPECT_NE(test::error_of([&] { DecisionFilter(settings(alarm_cost), tick); }).find("above 0"), std::string::npos);
  EXPECT_NE(test::error_of([&] { DecisionFilter(settings(), microseconds{0}); }).find("more than 0"), std::string::npos);
}

TEST(Decision, WithoutAFilterConfirms) {
  const std::vector<Touch> predicted{Touch::slip, Touch::none, Touch::slip, Touch::slip};
  EXPECT_EQ(decided({.confirmation = {2, 3}}, tick, predicted, {}), confirmed(predicted, {2, 3}));
  RunningDecision running({.confirmation = {2, 3}}, tick);
  std::vector<Touch> verdicts;
  verdicts.reserve(predicted.size());
  for (const Touch touch : predicted) verdicts.push_back(running.next(touch, {}));
  EXPECT_EQ(verdicts, confirmed(predicted, {2, 3}));
}

TEST(Decision, OfAnOlderModelHasNoFilterAndSaysWhatToDo) {
  const std::string error = test::error_of([] { filter_of({"models/old"}, {}, 1); });
  EXPECT_NE(error.find("models/old: has no rates"), std::string::npos) << error;
  EXPECT_NE(error.find("train it again"), std::string::npos) << error;
}

}  // namespace
}  // namespace tactile::model
