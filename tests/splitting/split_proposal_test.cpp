#include "tactile/splitting/split_proposal.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "support/temporary_folder.hpp"
#include "tactile/core/random.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile::splitting {
namespace {

/// What a burst does to the skin: a marker becomes brighter or darker, or moves aside.
enum class Change : std::uint8_t { brighter, darker, aside };

struct SkinBurst {
  double start_s = 0;
  Change change = Change::brighter;
  double length_s = 0.2;
};

struct SkinRecording {
  std::vector<SkinBurst> bursts;
  double length_s = 0;
  double noise_per_ms = 2;                          ///< over the image
  std::vector<std::pair<double, double>> off = {};  ///< [from, to) s without any event
};

class SplitProposalOf : public testing::Test {
 protected:
  /// The touches of each proposed run: "press slip, press".
  std::string runs_of_recording(const SkinRecording& made, const ProposeOptions& options = {}) {
    std::filesystem::remove(folder / "events.aedat4");
    write(made);
    events::RecordingReader recording(folder / "events.aedat4");
    std::string text;
    for (const ProposedRun& run : runs_of(propose_runs(split_source_at(folder / "events.aedat4"), recording, options))) {
      text += text.empty() ? "" : ",";
      for (const SeenTouch& touch : run.touches) text += " " + std::string(name_of(touch.kind));
    }
    return text;
  }

  test::TemporaryFolder folder;

 private:
  void write(const SkinRecording& made) {
    Random random(5);
    events::RecordingWriter writer(folder / "events.aedat4", {events::event_stream_declaration({64, 48}, "DVXplorer_TEST")});
    std::vector<events::Event> all;
    const auto add = [&](std::int64_t ms, std::uint64_t x, std::uint64_t y, bool on) {
      all.push_back({.t = camera_time(1'000'000 + 1000 * ms),
                     .x = static_cast<std::int16_t>(x),
                     .y = static_cast<std::int16_t>(y),
                     .on = static_cast<std::uint8_t>(on)});
    };
    for (std::int64_t ms = 0; ms < static_cast<std::int64_t>(1000 * made.length_s); ++ms) {
      const double s = 1e-3 * static_cast<double>(ms);
      bool is_off = false;
      for (const auto& [from, to] : made.off) is_off = is_off || (from <= s && s < to);
      if (is_off) continue;
      for (std::uint64_t n = random.poisson(made.noise_per_ms); n > 0; --n)
        add(ms, random.below(64), random.below(48), random.below(2) == 1);
      for (const SkinBurst& burst : made.bursts) {
        if (s < burst.start_s || s >= burst.start_s + burst.length_s) continue;
        const std::uint64_t left = burst.change == Change::aside ? 32 : 16;
        for (std::uint64_t n = random.poisson(15); n > 0; --n) {
          const std::uint64_t x = left + random.below(16);
          add(ms, x, 16 + random.below(16), burst.change == Change::aside ? x < 40 : burst.change == Change::brighter);
        }
      }
    }
    writer.write_events(0, all);
    writer.close();
  }
};

constexpr Change press = Change::brighter, release = Change::darker, slip = Change::aside;

TEST_F(SplitProposalOf, ARunDoesNotEndInItsHoldHoweverLongThatIs) {
  EXPECT_EQ(runs_of_recording({.bursts = {{1, press}, {4.5, slip, 0.5}, {9, press}, {10, slip, 0.5}}, .length_s = 11}),
            " press slip, press slip");
}

TEST_F(SplitProposalOf, ARunEndsWithTheReleaseOfItsPress) {
  EXPECT_EQ(runs_of_recording({.bursts = {{1, press}, {4.5, release}, {9, press}, {12.5, release}}, .length_s = 14}),
            " press release, press release");
}

TEST_F(SplitProposalOf, APauseOfTheRecordingEndsARun) {
  const SkinRecording made{.bursts = {{1, press}, {4.5, slip, 0.5}}, .length_s = 6, .off = {{1.8, 4.0}}};
  EXPECT_EQ(runs_of_recording(made), " press, press");
}

TEST_F(SplitProposalOf, TheSilenceOfASensorWithLittleNoiseIsNoPause) {
  EXPECT_EQ(runs_of_recording({.bursts = {{1, press}, {4.5, slip, 0.5}, {9, press}}, .length_s = 11, .noise_per_ms = 0.01}),
            " press slip, press");
}

/// Six runs; the third one is held for long.
const SkinRecording six_runs{.bursts = {{1, press},
                                        {2, slip, 0.5},
                                        {7, press},
                                        {8, slip, 0.5},
                                        {13, press},
                                        {21, release},
                                        {26, press},
                                        {27, slip, 0.5},
                                        {32, press},
                                        {33, slip, 0.5},
                                        {38, press},
                                        {39, slip, 0.5}},
                             .length_s = 41};

TEST_F(SplitProposalOf, APartEndsBetweenTwoRunsAndGrowsUntilItCan) {
  const std::string expected = " press slip, press slip, press release, press slip, press slip, press slip";
  EXPECT_EQ(runs_of_recording(six_runs), expected);
  for (const microseconds part : {9s, 15s}) {
    ProposeOptions options;
    options.course.part = part;
    EXPECT_EQ(runs_of_recording(six_runs, options), expected) << part.count();
  }
}

TEST_F(SplitProposalOf, PausesForMostOfTheTimeDoNotHideTheNoise) {
  const SkinRecording made{
      .bursts = {{1, press}, {2.5, slip, 0.5}, {31, press}, {32.5, slip, 0.5}, {61, press}, {62.5, slip, 0.5}},
      .length_s = 64,
      .off = {{4, 30}, {34, 60}}};
  EXPECT_EQ(runs_of_recording(made), " press slip, press slip, press slip");
}

}  // namespace
}  // namespace tactile::splitting
