#include "tactile/experiments/trade/experiment_design.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace tactile::trade {
namespace {

std::size_t differing(const TradeSetting& a, const TradeSetting& b) {
  const nlohmann::json first = a, second = b;
  std::size_t count = 0;
  for (const auto& [key, value] : first.items()) count += value != second.at(key) ? 1U : 0U;
  return count;
}

TEST(TradeSetting, HasAnIdThatFileNamesMayContain) {
  TradeSetting flipped, worsened;
  flipped.augmentation = joined_augmentation_named("flip+shift");
  worsened.augmentation = joined_augmentation_named("stress:noise:200+stress:vibration:2:hz=120+stress:loss:40+stress:shift:4");
  EXPECT_TRUE(id_of(flipped).ends_with("-flip+shift")) << id_of(flipped);
  EXPECT_EQ(id_of(worsened).find_first_of(":=,"), std::string::npos) << id_of(worsened);
  EXPECT_EQ(text_of(flipped), "augment flip+shift");
  TradeSetting other = worsened;
  other.augmentation.stress.pop_back();
  EXPECT_NE(id_of(other), id_of(worsened));
}

TEST(OneAtATime, HasTheUsualSettingFirstAndEveryOtherValueOnce) {
  const auto settings = one_at_a_time({}, {});
  EXPECT_EQ(settings.front(), TradeSetting{});
  // 5 histories, 4 ticks, 2 factors, 1 method to resize, 2 to denoise, 1 engine and precision each, 1 augmentation, 1 other kind.
  EXPECT_EQ(settings.size(), 1U + 5 + 4 + 2 + 1 + 2 + 1 + 1 + 1 + 1);
  std::set<std::string> ids;
  for (const TradeSetting& setting : settings) {
    EXPECT_TRUE(ids.insert(id_of(setting)).second) << id_of(setting);
    if (!(setting == TradeSetting{}) && setting.kind == model::ModelKind::lenet) {
      EXPECT_EQ(differing(setting, {}), 1U) << id_of(setting);
    }
  }
}

TEST(OneAtATime, LeavesOutPairsThatDoNotDivideAndNamesThem) {
  TradeLevels levels;
  const auto pairs = left_out_pairs(levels);
  std::set<std::pair<std::int64_t, std::int64_t>> named;
  for (const LeftOutPair& pair : pairs) named.emplace(pair.history.count(), pair.tick.count());
  const std::set<std::pair<std::int64_t, std::int64_t>> expected{{2000, 4000},  {2000, 5000},  {2000, 10000},
                                                                 {10000, 4000}, {30000, 4000}, {50000, 4000}};
  EXPECT_EQ(named, expected);
  levels.histories = {30ms};
  TradeSetting usual;
  usual.rendering.history = 30ms;
  const auto settings = one_at_a_time(usual, levels);
  EXPECT_TRUE(std::none_of(settings.begin(), settings.end(),
                           [](const TradeSetting& setting) { return setting.rendering.tick == microseconds{4000}; }));
}

TEST(AllCombinations, AreThoseThatMakeSense) {
  TradeLevels levels;
  levels.histories = {2ms, 40ms};
  levels.ticks = {2ms, 4ms};
  levels.factors = {0.2};
  levels.resizes = {heatmaps::Resize::area};
  levels.denoises = {heatmaps::Denoise::mean};
  levels.augmentations = {{}};
  const auto settings = all_combinations({}, levels);
  // Three pairs divide; libtorch goes with fp32 alone, ours with both precisions. A stream has only its two ticks.
  EXPECT_EQ(settings.size(), 3U * (1 + 2) + 2);
  for (const TradeSetting& setting : settings) EXPECT_FALSE(why_impossible(setting)) << id_of(setting);
}

TEST(WhyImpossible, ReportsWhichIsNoWholeNumberOfWhich) {
  TradeSetting setting;
  setting.rendering.history = 10ms;
  setting.rendering.tick = 4ms;
  EXPECT_EQ(why_impossible(setting).value_or(""), "t_h 10 ms is no whole number of ticks of 4 ms");
}

TEST(OneAtATime, AKindWithoutHeatmapsHasNoneOfTheirValues) {
  TradeSetting usual;
  usual.rendering.factor = 0.25;
  usual.rendering.history = 20ms;
  usual.precision = model::Precision::int8;
  TradeSetting stream;
  stream.kind = model::ModelKind::stream;
  stream.rendering.history = 2ms;
  EXPECT_EQ(without_idle_values(usual), usual);
  const auto settings = one_at_a_time(usual, {});
  EXPECT_EQ(std::count(settings.begin(), settings.end(), stream), 1);
  // If a stream is usual, other ticks are tried, but no value of a heatmap or of LeNet.
  std::size_t streams = 0;
  for (const TradeSetting& setting : one_at_a_time(stream, {})) {
    if (setting.kind != model::ModelKind::stream) continue;
    ++streams;
    EXPECT_EQ(setting, without_idle_values(setting)) << id_of(setting);
  }
  EXPECT_EQ(streams, 1U + 4);
  stream.precision = model::Precision::int8;
  EXPECT_EQ(why_impossible(stream).value_or(""),
            "a model of kind stream reads no heatmaps, and has one history, engine and precision");
}

TEST(PromisingCorners, JoinAKindOnlyWithValuesThatItHas) {
  TradeLevels levels;
  levels.histories = {40ms};
  levels.ticks = {2ms, 4ms};
  levels.factors = {0.2};
  levels.resizes = {heatmaps::Resize::area};
  levels.denoises = {heatmaps::Denoise::mean};
  levels.augmentations = {{}};
  levels.engines = {model::EngineKind::fast};
  levels.precisions = {model::Precision::fp32, model::Precision::int8};
  std::map<std::string, TradeOutcome> measured;
  for (const TradeSetting& setting : one_at_a_time({}, levels)) measured[id_of(setting)] = {0.9, 100, 5, 1.0, 0.1};
  TradeSetting stream, slower, rounded;
  stream.kind = model::ModelKind::stream;
  stream.rendering.history = 2ms;
  slower.rendering.tick = 4ms;
  rounded.precision = model::Precision::int8;
  measured[id_of(stream)] = {0.93, 12, 5, 0.8, 0.1};
  measured[id_of(slower)] = {0.9, 100, 5, 0.5, 0.1};
  measured[id_of(rounded)] = {0.91, 60, 5, 1.0, 0.1};
  const auto corners = promising_corners({}, levels, measured, 20);
  TradeSetting both = stream;
  both.rendering.tick = both.rendering.history = 4ms;
  EXPECT_NE(std::find(corners.begin(), corners.end(), both), corners.end());
  for (const TradeSetting& corner : corners) {
    EXPECT_FALSE(why_impossible(corner)) << id_of(corner);
    EXPECT_FALSE(corner.kind == model::ModelKind::stream && corner.precision != model::Precision::fp32) << id_of(corner);
  }
}

TEST(PromisingCorners, JoinWhatHelpsAloneAndLeaveWhatHarms) {
  TradeLevels levels;
  levels.histories = {20ms, 40ms, 50ms};
  levels.ticks = {2ms, 4ms};
  levels.factors = {0.1, 0.2};
  levels.resizes = {heatmaps::Resize::area};
  levels.denoises = {heatmaps::Denoise::mean};
  levels.engines = {model::EngineKind::fast, model::EngineKind::libtorch};
  levels.precisions = {model::Precision::fp32};
  std::map<std::string, TradeOutcome> measured;
  for (const TradeSetting& setting : one_at_a_time({}, levels)) measured[id_of(setting)] = {0.9, 100, 5, 1.0, 0.1};
  TradeSetting usual, shorter, smaller, slow;
  shorter.rendering.history = 20ms;
  smaller.rendering.factor = 0.1;
  slow.engine = model::EngineKind::libtorch;
  measured[id_of(shorter)] = {0.92, 90, 4, 1.0, 0.1};  // better in everything
  measured[id_of(smaller)] = {0.89, 50, 5, 1.0, 0.1};  // faster, a little less accurate
  measured[id_of(slow)] = {0.9, 900, 5, 1.0, 0.1};     // slower for nothing
  const auto corners = promising_corners(usual, levels, measured, 4);
  TradeSetting both = shorter;
  both.rendering.factor = 0.1;
  EXPECT_NE(std::find(corners.begin(), corners.end(), both), corners.end());
  for (const TradeSetting& corner : corners) {
    EXPECT_EQ(corner.engine, model::EngineKind::fast);
    EXPECT_GE(differing(corner, usual), 2U);
  }
}

TEST(PromisingCorners, AreNoMoreThanAskedForOfEachFront) {
  std::map<std::string, TradeOutcome> measured;
  double step = 0;
  for (const TradeSetting& setting : one_at_a_time({}, {})) {
    step += 1;
    measured[id_of(setting)] = {0.9 + 0.001 * step, 100 + step, 5 - 0.01 * step, 1.0 + 0.01 * step, 0.1};
  }
  EXPECT_LE(promising_corners({}, {}, measured, 3).size(), 6U);
  EXPECT_TRUE(promising_corners({}, {}, measured, 0).empty());
  EXPECT_TRUE(promising_corners({}, {}, {}, 3).empty()) << "nothing is known of the usual setting";
}

TEST(TradeSetting, IsNamedByItsDifferences) {
  TradeSetting setting;
  EXPECT_EQ(text_of(setting), "as usual");
  setting.rendering.history = 2500us;
  setting.rendering.tick = 500us;
  EXPECT_EQ(text_of(setting), "t_h 2.5 ms, tick 0.5 ms");
  EXPECT_EQ(id_of(setting), "th2.5-tick0.5-f0.2-area-mean-fast-fp32");
  TradeSetting stream;
  stream.kind = model::ModelKind::stream;
  stream.rendering.history = stream.rendering.tick = 1ms;
  EXPECT_EQ(text_of(stream), "stream, tick 1 ms");
  EXPECT_EQ(text_of({}, without_idle_values(stream)), "LeNet, t_h 40 ms, tick 2 ms");
  EXPECT_EQ(id_of(stream), "th1-tick1-f0.2-area-mean-fast-fp32-stream");
}

}  // namespace
}  // namespace tactile::trade
