#include "tactile/model/inference/stream_network.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "events/made_recording.hpp"
#include "model/stream_data.hpp"
#include "support/error_of.hpp"
#include "tactile/core/error.hpp"
#include "tactile/model/inference/stream_classifier.hpp"

namespace tactile::model {
namespace {

using Layout = StreamLayout;
using Numbers = std::vector<long double>;

constexpr events::SensorSize sensor{160, 120};

/// The formulas of the header, dense and in long double.
class Reference {
 public:
  explicit Reference(const Weights& weights) : weights_(weights) {}

  std::vector<double> advance(std::span<const std::uint8_t> counts) {
    std::vector<Numbers> all;
    for (std::size_t place = 0; place < Layout::places; ++place) {
      Numbers inputs;
      long double sum = 0;
      for (const std::uint8_t count : counts.subspan(place * Layout::cells_of_place, Layout::cells_of_place)) {
        sum += count;
        inputs.push_back(std::log1p(static_cast<long double>(count)));
      }
      inputs.push_back(std::log1p(sum));
      Numbers kept = relu(layer(1, 2, inputs));
      const Numbers now = kept;
      for (std::size_t span = 0; span < StreamSizes::spans.size(); ++span) {
        Numbers& mean = means_[place][span];
        mean.resize(now.size());
        const long double length = StreamSizes::spans[span];
        for (std::size_t i = 0; i < now.size(); ++i) mean[i] = (1 - 1 / length) * mean[i] + now[i] / length;
        kept.insert(kept.end(), mean.begin(), mean.end());
      }
      all.push_back(relu(layer(5, 6, relu(layer(3, 4, kept)))));
    }
    const Numbers logits = layer(11, 12, remembered(pooled(all)));
    return {static_cast<double>(logits[0]), static_cast<double>(logits[1]), static_cast<double>(logits[2])};
  }

 private:
  static Numbers relu(Numbers values) {
    for (long double& value : values) value = std::max(value, 0.0L);
    return values;
  }

  Numbers layer(std::size_t weight, std::size_t bias, const Numbers& inputs) const {
    Numbers outputs;
    for (std::size_t out = 0; out < weights_[bias].values.size(); ++out) {
      long double sum = weights_[bias].values[out];
      for (std::size_t in = 0; in < inputs.size(); ++in) sum += inputs[in] * weights_[weight].values[out * inputs.size() + in];
      outputs.push_back(sum);
    }
    return outputs;
  }

  static Numbers pooled(const std::vector<Numbers>& all) {
    constexpr std::size_t channels = StreamSizes::channels;
    Numbers pooled(4 * channels);
    for (std::size_t place = 0; place < all.size(); ++place) {
      const std::size_t column = place % 3, row = place / 3;
      const long double x = static_cast<long double>(column) - 1, y = static_cast<long double>(row) - 1;
      for (std::size_t i = 0; i < channels; ++i) {
        const long double value = all[place][i];
        pooled[i] += value / 9;
        pooled[channels + i] = std::max(pooled[channels + i], value);
        pooled[2 * channels + i] += x * value / 9;
        pooled[3 * channels + i] += y * value / 9;
      }
    }
    return pooled;
  }

  Numbers remembered(const Numbers& pooled) {
    memory_.resize(StreamSizes::memory);
    const Numbers input = layer(7, 9, pooled), own = layer(8, 10, memory_);
    const auto sigmoid = [](long double x) { return 1 / (1 + std::exp(-x)); };
    for (std::size_t i = 0; i < memory_.size(); ++i) {
      const std::size_t z = memory_.size() + i, n = 2 * memory_.size() + i;
      const long double reset = sigmoid(input[i] + own[i]), update = sigmoid(input[z] + own[z]);
      memory_[i] = (1 - update) * std::tanh(input[n] + reset * own[n]) + update * memory_[i];
    }
    return memory_;
  }

  const Weights& weights_;
  std::array<std::array<Numbers, StreamSizes::spans.size()>, Layout::places> means_{};
  Numbers memory_;
};

/// The events of a tick whose counts these are, on a sensor of 160 x 120 px: one pixel of each cell has them.
std::vector<events::Event> events_of(std::span<const std::uint8_t> counts, CameraTime t) {
  std::vector<events::Event> events;
  for (std::size_t polarity = 0; polarity < 2; ++polarity) {
    for (std::size_t row = 0; row < Layout::all_rows; ++row) {
      for (std::size_t column = 0; column < Layout::all_columns; ++column) {
        const std::size_t x = (column * 160 + Layout::all_columns - 1) / Layout::all_columns;
        const std::size_t y = (row * 120 + Layout::all_rows - 1) / Layout::all_rows;
        const events::Event event{t, static_cast<std::int16_t>(x), static_cast<std::int16_t>(y),
                                  static_cast<std::uint8_t>(polarity)};
        events.insert(events.end(), counts[Layout::cell(polarity, row, column)], event);
      }
    }
  }
  return events;
}

TEST(StreamLayout, NumbersEachCellOnce) {
  std::vector<int> times(Layout::cells);
  for (std::size_t polarity = 0; polarity < 2; ++polarity) {
    for (std::size_t row = 0; row < Layout::all_rows; ++row) {
      for (std::size_t column = 0; column < Layout::all_columns; ++column) ++times[Layout::cell(polarity, row, column)];
    }
  }
  EXPECT_EQ(times, std::vector<int>(Layout::cells, 1));
}

TEST(StreamCounts, CountsWhatLiesInTheGrid) {
  StreamCounts counts(sensor, {10, 20, 130, 110});
  const auto count = [&counts](int x, int y, int on) {
    counts.count({CameraTime{0us}, static_cast<std::int16_t>(x), static_cast<std::int16_t>(y), static_cast<std::uint8_t>(on)});
  };
  for (const auto& [x, y] : {std::pair{9, 50}, {130, 50}, {50, 19}, {50, 110}, {0, 0}, {159, 119}}) count(x, y, 1);
  EXPECT_TRUE(counts.touched().empty()) << "outside";
  for (int times = 0; times < 300; ++times) count(10, 20, 0);
  count(129, 109, 1);
  EXPECT_EQ(counts.at(Layout::cell(0, 0, 0)), 300U);
  EXPECT_EQ(counts.at(Layout::cell(1, Layout::all_rows - 1, Layout::all_columns - 1)), 1U);
  EXPECT_EQ(counts.touched().size(), 2U);
  counts.clear();
  EXPECT_TRUE(counts.touched().empty());
  EXPECT_EQ(counts.at(Layout::cell(0, 0, 0)), 0U);
  EXPECT_THROW(StreamCounts({0, 10}, {0, 0, 1, 1}), Error);
  EXPECT_THROW(StreamCounts(sensor, {10, 0, 10, 5}), Error);
  EXPECT_THROW(StreamCounts(sensor, {0, 0, std::nan(""), 5}), Error);
}

TEST(StreamCounts, TheGridHoldsWhereTheEventsGather) {
  std::vector<std::uint64_t> columns(100), rows(50, 1);
  for (std::size_t x = 30; x < 70; ++x) columns[x] = 1'000;
  columns[2] = columns[90] = 5;  // a hot pixel's
  EXPECT_EQ(grid_around(columns, rows, 0.001), (StreamGrid{30, 0, 70, 50}));
  EXPECT_EQ(grid_around(std::vector<std::uint64_t>(100), rows, 0), (StreamGrid{0, 0, 100, 50})) << "no events";
  EXPECT_EQ(grid_around(std::vector<std::uint64_t>{0, 7, 0}, rows, 0.4), (StreamGrid{1, 20, 2, 30})) << "one column has them all";
}

TEST(StreamNetwork, AgreesWithTheDenseFormulasInLongDouble) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const Weights weights = test::stream_weights(seed);
    const auto network = std::make_shared<const StreamNetwork>(weights);
    StreamClassifier classifier(sensor, 2ms, {}, network);
    Reference reference(weights);
    const std::vector<std::uint8_t> counts = test::stream_counts(400, seed);
    for (std::size_t tick = 0; tick < 400; ++tick) {
      const auto of_tick = std::span(counts).subspan(tick * Layout::cells, Layout::cells);
      const CameraTime end{(static_cast<std::int64_t>(tick) + 1) * 2'000us};
      std::vector<events::Event> events = events_of(of_tick, before(end, 1us));
      if (tick == 0) events.insert(events.begin(), {CameraTime{0us}, 159, 119, 0, {}});  // a first tick needs an event
      classifier.add(events);
      classifier.move_to(end);
      std::vector<std::uint8_t> seen(of_tick.begin(), of_tick.end());
      if (tick == 0) ++seen[Layout::cell(0, Layout::all_rows - 1, Layout::all_columns - 1)];
      const std::vector<double> expected = reference.advance(seen);
      const double largest = std::max({std::abs(expected[0]), std::abs(expected[1]), std::abs(expected[2])});
      const Logits logits = classifier.classify();
      for (std::size_t k = 0; k < touch_count; ++k) ASSERT_NEAR(logits[k], expected[k], 1e-5 * largest) << tick;
    }
  }
}

TEST(StreamNetwork, RefusesWeightsOfOtherShapesOrThatLeaveFloat32) {
  Weights weights = test::stream_weights();
  for (const std::size_t i : {1U, 3U, 5U}) {
    for (float& value : weights[i].values) value *= 1e15F;
  }
  EXPECT_NE(test::error_of([&] { StreamNetwork{weights}; }).find("of smaller weights"), std::string::npos);
  weights = test::stream_weights();
  weights.front().values = {5, 0, 5, 10};
  EXPECT_NE(test::error_of([&] { StreamNetwork{weights}; }).find("expected a rectangle of the sensor"), std::string::npos);
  weights = test::stream_weights();
  weights.pop_back();
  EXPECT_THROW(StreamNetwork{weights}, Error);
}

TEST(StreamClassifier, AdvancesAtEveryTickWhicheverAreAskedFor) {
  const auto network = std::make_shared<const StreamNetwork>(test::stream_weights());
  const std::vector<events::Event> events = test::steady_events(8'000, 1'000, 20, sensor);
  StreamClassifier every(sensor, 2ms, {}, network), few(sensor, 2ms, {}, network);
  every.add(events);
  few.add(events);
  for (CameraTime t{0us}; t <= CameraTime{150ms}; t = after(t, 2ms)) {
    every.move_to(t);
    if (us_of(t) % 14'000 != 0) continue;
    few.move_to(t);
    ASSERT_EQ(every.classify(), few.classify()) << us_of(t);
    ASSERT_EQ(every.events(), few.events());
    const Logits again = few.classify();
    few.move_to(t);
    ASSERT_EQ(few.classify(), again) << "the same tick changes nothing";
  }
  EXPECT_GT(every.events(), 0U);
  EXPECT_THROW(every.move_to(CameraTime{100ms}), Error);
  EXPECT_THROW(every.move_to(CameraTime{151ms}), Error) << "no whole tick";
  EXPECT_THROW(every.add(std::vector<events::Event>{{CameraTime{0us}, 1, 1, 1, {}}}), Error) << "back in time";
  EXPECT_THROW(every.add(std::vector<events::Event>{{CameraTime{1s}, 160, 1, 1, {}}}), Error) << "outside";
  StreamClassifier fresh(sensor, 2ms, {}, network);
  every.restart();
  every.add(events);
  fresh.add(events);
  every.move_to(CameraTime{40ms});
  fresh.move_to(CameraTime{40ms});
  EXPECT_EQ(every.classify(), fresh.classify());
  EXPECT_THROW(StreamClassifier(sensor, 0us, {}, network), Error);
}

TEST(StreamClassifier, SkipsALongSilenceAsIfItHadComputedIt) {
  const Weights weights = test::stream_weights();
  const auto network = std::make_shared<const StreamNetwork>(weights);
  StreamClassifier classifier(sensor, 2ms, {}, network);
  const std::vector<events::Event> first = test::steady_events(500, 1'000, 20, sensor);
  classifier.add(first);
  const CameraTime woken{3600s};
  const std::vector<events::Event> last{{woken, 80, 60, 1, {}}};
  classifier.add(last);
  classifier.move_to(before(woken, 2ms));
  const Logits at_rest = classifier.classify();
  EXPECT_EQ(classifier.events(), 0U);
  classifier.move_to(after(woken, 2ms));
  EXPECT_EQ(classifier.events(), 1U);

  Reference reference(weights);
  const std::vector<std::uint8_t> none(Layout::cells);
  std::vector<std::uint8_t> counts = none;
  StreamCounts of_tick(sensor, network->grid());
  std::size_t next = 0;
  std::vector<double> expected;
  for (CameraTime t{2ms}; t <= CameraTime{8s}; t = after(t, 2ms)) {
    of_tick.clear();
    for (; next < first.size() && first[next].t < t; ++next) of_tick.count(first[next]);
    counts = none;
    for (const std::uint16_t cell : of_tick.touched()) counts[cell] = static_cast<std::uint8_t>(of_tick.at(cell));
    expected = reference.advance(counts);
  }
  for (std::size_t k = 0; k < touch_count; ++k) EXPECT_NEAR(at_rest[k], expected[k], 2e-5) << k;
  of_tick.clear();
  of_tick.count(last.front());
  counts = none;
  counts[of_tick.touched().front()] = 1;
  expected = reference.advance(counts);
  const Logits logits = classifier.classify();
  for (std::size_t k = 0; k < touch_count; ++k) EXPECT_NEAR(logits[k], expected[k], 2e-5) << k;
  EXPECT_NE(logits, at_rest);
}

TEST(StreamClassifier, LeavesOutMaskedPixels) {
  const auto network = std::make_shared<const StreamNetwork>(test::stream_weights());
  StreamClassifier masked(sensor, 2ms, {{7, 9}}, network), without(sensor, 2ms, {}, network);
  const std::vector<events::Event> all{
      {CameraTime{1ms}, 7, 9, 1, {}}, {CameraTime{1ms}, 8, 9, 1, {}}, {CameraTime{1ms}, 7, 9, 0, {}}};
  masked.add(all);
  without.add(std::span(all).subspan(1, 1));
  masked.move_to(CameraTime{4ms});
  without.move_to(CameraTime{4ms});
  EXPECT_EQ(masked.classify(), without.classify());
}

}  // namespace
}  // namespace tactile::model
