#include "tactile/heatmaps/render_samples.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "events/made_recording.hpp"
#include "heatmaps/dense_reference.hpp"
#include "support/error_of.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/heatmaps/run_heatmaps.hpp"
#include "tactile/heatmaps/store_heatmaps.hpp"
#include "tactile/windows/write_dataset.hpp"
#include "windows/made_runs.hpp"

namespace tactile::heatmaps {
namespace {

class RenderSamples : public testing::Test {
 protected:
  void SetUp() override {
    test::make_three_runs(folder.path());
    windows::write_dataset(folder.path(), file());
  }
  std::filesystem::path file() const { return folder / "dataset.h5"; }
  static std::vector<std::uint32_t> all_of(const windows::Dataset& dataset) {
    std::vector<std::uint32_t> indexes(dataset.samples().size());
    std::iota(indexes.begin(), indexes.end(), 0U);
    return indexes;
  }
  test::TemporaryFolder folder;
};

std::string message_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& e) {
    return e.what();
  }
  return "nothing thrown";
}

/// Rounded as stored; where the true value lies at a rounding boundary, as `rendered` has it.
void expect_rounded(std::span<const std::uint8_t> rendered, const std::vector<long double>& expected, const std::string& where) {
  ASSERT_EQ(rendered.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const long double to_boundary = std::abs(expected[i] + 0.5L - std::round(expected[i] + 0.5L));
    if (to_boundary > 1e-3L) {
      ASSERT_EQ(static_cast<int>(rendered[i]), static_cast<int>(std::floor(expected[i] + 0.5L))) << where << ", pixel " << i;
    }
  }
}

TEST_F(RenderSamples, GivesThePlainFormulaOfTheWholeRecordingForEachSample) {
  const windows::Dataset dataset(file());
  for (const HeatmapOptions& options : {HeatmapOptions{.history = 50ms}, HeatmapOptions{.history = 2ms, .denoise = Denoise::none},
                                        HeatmapOptions{.history = 20ms, .resize = Resize::linear, .factor = 0.1}}) {
    const auto heatmaps = render_samples(dataset, options, all_of(dataset), 2);
    const std::size_t size = heatmaps.size() / dataset.samples().size();
    for (std::uint32_t index = 0; index < 3; ++index) {
      // From the run's own events, not from those that the dataset stores.
      const auto events = test::random_events({.seed = index + 1, .begin_us = index == 1 ? -700'123 : 1'700'000'000'000'301});
      for (std::size_t i = 0; i < dataset.samples().size(); ++i) {
        if (dataset.samples()[i].run_index != index) continue;
        const auto counts = test::dense_counts(events, dataset.sensor(), dataset.samples()[i].t, options.history);
        expect_rounded(std::span(heatmaps).subspan(i * size, size), test::dense_heatmap(counts, dataset.sensor(), options),
                       "sample " + std::to_string(i));
      }
    }
  }
}

TEST_F(RenderSamples, DoesNotDependOnThreadsOrderOrTheOtherSamples) {
  const windows::Dataset dataset(file());
  const HeatmapOptions options{.history = 40ms};
  const auto all = render_samples(dataset, options, all_of(dataset), 1);
  EXPECT_EQ(all, render_samples(dataset, options, all_of(dataset), 2));
  const std::size_t size = all.size() / dataset.samples().size();
  const std::vector<std::uint32_t> some{269, 3, 100, 3, 250, 99};
  const auto rendered = render_samples(dataset, options, some, 2);
  for (std::size_t i = 0; i < some.size(); ++i) {
    EXPECT_TRUE(std::equal(rendered.begin() + static_cast<std::ptrdiff_t>(i * size),
                           rendered.begin() + static_cast<std::ptrdiff_t>((i + 1) * size),
                           all.begin() + static_cast<std::ptrdiff_t>(some[i] * size)));
  }
  EXPECT_TRUE(render_samples(dataset, options, {}, 2).empty());
}

TEST_F(RenderSamples, RefusesAHistoryThatIsNotStoredAndSamplesThatLieAtNoTick) {
  const windows::Dataset dataset(file());
  const std::string message = message_of([&] { render_samples(dataset, {.history = 52ms}, std::vector<std::uint32_t>{0}); });
  EXPECT_NE(message.find("history of 52000 us; expected at most the 50000 us"), std::string::npos) << message;
  EXPECT_NE(message_of([&] { check_renders(dataset, {.history = 30ms, .tick = 3ms}); }).find("is not at a tick"),
            std::string::npos);
  EXPECT_NO_THROW(check_renders(dataset, {.history = 3ms, .tick = 1ms}));
  EXPECT_THROW(render_samples(dataset, {.history = 41ms}, std::vector<std::uint32_t>{0}), Error);
  EXPECT_THROW(render_samples(dataset, {}, std::vector<std::uint32_t>{270}), Error);
}

TEST_F(RenderSamples, StoresWhatItRendersOfSeveralHistoriesAtOnce) {
  const std::vector<HeatmapOptions> histories{
      {.history = 40ms},
      {.history = 2500us, .tick = 500us, .denoise = Denoise::none, .resize = Resize::linear},
      {.history = 40ms},  // again
      {.history = 10ms, .denoise = Denoise::literal, .factor = 0.1}};
  const auto first = store_heatmaps(windows::Dataset(file()), std::span(histories).first(1), 2);
  ASSERT_EQ(first.size(), 1U);
  EXPECT_FALSE(first[0].kept);
  std::uint64_t reported = 0;
  const auto stored = store_heatmaps(windows::Dataset(file()), histories, 2, [&](const Progress& progress) {
    EXPECT_GT(progress.done, reported);
    reported = progress.done;
  });
  const windows::Dataset dataset(file());
  EXPECT_EQ(reported, dataset.samples().size());
  ASSERT_EQ(stored.size(), histories.size());
  ASSERT_EQ(dataset.heatmaps().size(), 3U);
  for (std::size_t i = 0; i < histories.size(); ++i) {
    EXPECT_EQ(stored[i].heatmaps.name, stored_name(histories[i]));
    EXPECT_EQ(stored[i].kept, i % 2 == 0) << i;
    const auto found = dataset.find_heatmaps(stored_name(histories[i]));
    ASSERT_TRUE(found);
    EXPECT_EQ(found->settings.get<HeatmapOptions>(), histories[i]);
    EXPECT_EQ(dataset.read_heatmaps(found->name, all_of(dataset)), render_samples(dataset, histories[i], all_of(dataset)));
  }
  for (const StoredHistory& each : store_heatmaps(dataset, histories)) EXPECT_TRUE(each.kept);
}

TEST_F(RenderSamples, ListsAHistoryNamedTwiceOnce) {
  const std::vector<HeatmapOptions> twice(2);
  const auto stored = store_heatmaps(windows::Dataset(file()), twice);
  EXPECT_FALSE(stored[0].kept);
  EXPECT_TRUE(stored[1].kept);
  EXPECT_EQ(windows::Dataset(file()).heatmaps().size(), 1U);
}

TEST_F(RenderSamples, StoresNoHistoryIfOneIsRefusedOrTheStepIsEnded) {
  const std::vector<HeatmapOptions> one_too_long{{.history = 40ms}, {.history = 52ms}}, two{{.history = 40ms}, {.history = 10ms}};
  EXPECT_THROW(store_heatmaps(windows::Dataset(file()), one_too_long), Error);
  for (const std::uint64_t most : {0U, 100U}) {
    for (const unsigned threads : {1U, 2U, 3U}) {
      const auto end = [&](const Progress& progress) {
        if (progress.done > most) throw Error("ended");
      };
      EXPECT_EQ(message_of([&] { store_heatmaps(windows::Dataset(file()), two, threads, end); }), "ended");
    }
  }
  EXPECT_TRUE(windows::Dataset(file()).heatmaps().empty());
  for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
    EXPECT_EQ(entry.path().filename().string().find("th_0"), std::string::npos) << entry.path();
}

TEST_F(RenderSamples, RendersAHistoryAgainIfItsFileIsGone) {
  const std::vector<HeatmapOptions> plain(1);
  store_heatmaps(windows::Dataset(file()), plain);
  std::filesystem::remove(folder / "dataset.th_040.h5");
  EXPECT_THROW(windows::Dataset(file()).heatmaps(), Error);
  EXPECT_FALSE(store_heatmaps(windows::Dataset(file()), plain)[0].kept);
  EXPECT_EQ(windows::Dataset(file()).heatmaps().size(), 1U);
}

TEST(ForEveryTick, HandsOverEachFullTickWithItsHeatmapAndCount) {
  const test::LabelledRun run{.begin_us = -100'301, .length_us = 200'000};
  const std::vector<events::Event> events = test::random_events(run);
  const HeatmapOptions options{.history = 20ms};
  std::vector<CameraTime> ticks;
  const TickRange range =
      for_every_tick(events, run.sensor, options, [&](CameraTime t, std::span<const std::uint8_t> heatmap, std::uint64_t count) {
        ticks.push_back(t);
        const auto counts = test::dense_counts(events, run.sensor, t, options.history);
        EXPECT_EQ(count, std::accumulate(counts.begin(), counts.end(), std::uint64_t{0}));
        expect_rounded(heatmap, test::dense_heatmap(counts, run.sensor, options), std::to_string(us_of(t)));
      });
  const TickRange expected = full_ticks(events.front().t, events.back().t, options.history, options.tick);
  EXPECT_EQ(range.first, expected.first);
  ASSERT_EQ(range.count, expected.count);
  ASSERT_EQ(static_cast<std::int64_t>(ticks.size()), expected.count);
  for (std::int64_t i = 0; i < expected.count; ++i) EXPECT_EQ(ticks[static_cast<std::size_t>(i)], expected.at(i));
}

TEST(ForEveryTick, GivesTheSameFromARecording) {
  const test::TemporaryFolder folder;
  const test::LabelledRun run{.length_us = 300'000, .mean_gap_us = 10};
  const RunFolder made = test::make_run(folder.path(), run);
  using Seen = std::vector<std::pair<CameraTime, std::vector<std::uint8_t>>>;
  Seen from_memory, from_file;
  const auto see = [](Seen& seen) {
    return [&seen](CameraTime t, std::span<const std::uint8_t> heatmap, std::uint64_t) {
      seen.emplace_back(t, std::vector(heatmap.begin(), heatmap.end()));
    };
  };
  for_every_tick(test::random_events(run), run.sensor, {}, see(from_memory));
  events::RecordingReader recording(made.events());
  const TickRange range = for_every_tick(recording, events::event_stream(recording).id, {}, see(from_file));
  EXPECT_GT(range.count, 100);
  EXPECT_EQ(from_memory, from_file);

  // A change that holds every event back until the end, and one that loses all of them: the ticks stay.
  std::vector<events::Event> held;
  Seen late, empty;
  const ChangeEvents hold_back = [&held](std::span<const events::Event> recorded, bool is_last) {
    held.insert(held.end(), recorded.begin(), recorded.end());
    return is_last ? std::span<const events::Event>(held) : std::span<const events::Event>();
  };
  for_every_tick(recording, events::event_stream(recording).id, {}, see(late), hold_back);
  EXPECT_EQ(late, from_file);
  const TickRange without = for_every_tick(recording, events::event_stream(recording).id, {}, see(empty),
                                           [](std::span<const events::Event>, bool) { return std::span<const events::Event>(); });
  EXPECT_EQ(without.first, range.first);
  ASSERT_EQ(without.count, range.count);
  for (const auto& [t, heatmap] : empty) EXPECT_EQ(std::count(heatmap.begin(), heatmap.end(), 0), std::ssize(heatmap));
}

TEST(ForEveryTick, HasNoneIfTheRunIsShorterThanTheHistory) {
  const auto never = [](CameraTime, std::span<const std::uint8_t>, std::uint64_t) { FAIL(); };
  EXPECT_EQ(for_every_tick({}, {4, 3}, {.factor = 1}, never).count, 0);
  EXPECT_EQ(for_every_tick(test::random_events({.length_us = 39'000}), {40, 30}, {}, never).count, 0);
}

TEST(ForEveryTick, EndsAtTheEndOfTheClock) {
  constexpr std::int64_t latest = std::numeric_limits<std::int64_t>::max();
  const std::vector<events::Event> events{
      {.t = camera_time(latest - 9'000)}, {.t = camera_time(latest - 1'000), .x = 1}, {.t = camera_time(latest)}};
  std::vector<std::uint64_t> counts;
  const TickRange range =
      for_every_tick(events, {2, 1}, {.history = 4ms, .factor = 1},
                     [&](CameraTime, std::span<const std::uint8_t>, std::uint64_t count) { counts.push_back(count); });
  EXPECT_EQ(static_cast<std::int64_t>(counts.size()), range.count);
  EXPECT_GE(range.count, 2);
  EXPECT_LE(range.count, 3);
}

TEST(ForEveryTick, RefusesEventsThatGoBackInTime) {
  const std::vector<events::Event> events{{.t = camera_time(10)}, {.t = camera_time(9)}};
  EXPECT_THROW(for_every_tick(events, {5, 5}, {}, [](CameraTime, std::span<const std::uint8_t>, std::uint64_t) {}), Error);
}

TEST(ForEveryTick, RefusesARecordingThatSeemsToLastAYear) {
  const test::TemporaryFolder folder;
  constexpr std::int64_t year = 365 * std::int64_t{86'400'000'000};
  std::vector<events::Event> events = test::steady_events(2'000, 1'000, 50, {40, 30});
  for (const std::int64_t last : {std::int64_t{200'000}, year, std::numeric_limits<std::int64_t>::max()}) {
    events.push_back(test::event_at(last));
    const std::filesystem::path file = folder / (std::to_string(last) + ".aedat4");
    test::write_plain_recording(file, events, {40, 30});
    events.pop_back();
    events::RecordingReader reader(file);
    const HeatmapOptions options{.history = 10ms, .tick = 2ms};
    std::int64_t seen = 0;
    const auto count = [&](CameraTime, std::span<const std::uint8_t>, std::uint64_t) { ++seen; };
    if (last < year) {
      EXPECT_EQ(for_every_tick(reader, 0, options, count).count, 95);
      EXPECT_EQ(seen, 95);
      EXPECT_EQ(listed_ticks(reader, 0, options).count, 95);
      continue;
    }
    EXPECT_NE(test::error_of([&] { for_every_tick(reader, 0, options, count); }).find("ticks of 2000 us from the first event"),
              std::string::npos);
    EXPECT_EQ(seen, 0);
  }
}

}  // namespace
}  // namespace tactile::heatmaps
