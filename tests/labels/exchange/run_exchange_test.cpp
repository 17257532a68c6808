#include "tactile/labels/exchange/run_exchange.hpp"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include "labels/altered_run.hpp"
#include "support/error_of.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/labels/saved_labels.hpp"

namespace tactile::labels {
namespace {

/// A labelled run whose film's clock is that of the truth, to 20 ms.
class ReadEdits : public testing::Test {
 protected:
  void SetUp() override {
    Labels labels = made.labels();
    labels.video_clock.emplace().relation = made.truth.video_clock.value();
    labels.video_clock->offset_low_us = labels.video_clock->relation.offset_us - 20'000;
    labels.video_clock->offset_high_us = labels.video_clock->relation.offset_us + 20'000;
    write_labels(made.run.labels(), labels);
  }

  /// The start of the first press that a file of these rows gives.
  alignment::UncertainTime start_by(const std::string& rows) {
    const std::filesystem::path file = folder / "labels.csv";
    write_whole(file, rows);
    const std::vector<ImportedRun> read = read_edits(std::vector{file}, {}, {}, std::vector{made.run});
    const RecordingSpan span = span_of_events(made.run);
    return with_edit(read_labels(made.run.labels()), read.at(0).edit, span).intervals.at(0).start;
  }

  test::AlteredRun made;
  test::TemporaryFolder folder;
};

TEST_F(ReadEdits, CountFromTheRunsFilmIfTheFileDoesNotSayWhenItBegan) {
  const CameraTime first_frame = made.truth.video_clock.value().camera_from(VideoTime{});
  const std::int64_t from_film_ms = between(first_frame, span_of_events(made.run).first).count() / 1'000 + 500;
  const std::string rows = fmt::format("class,start_s,end_s,origin\npress,{:.3f},{:.3f},video\n",
                                       1e-3 * static_cast<double>(from_film_ms), 1e-3 * static_cast<double>(from_film_ms + 100));
  const alignment::UncertainTime start = start_by(rows);
  const CameraTime shown = made.truth.video_clock.value().camera_from(VideoTime{microseconds{1'000 * from_film_ms}});
  EXPECT_LE(std::chrono::abs(between(shown, start.at)), 1ms);
  EXPECT_GE(between(start.low, start.at), 20ms);

  Labels without = read_labels(made.run.labels());
  without.video_clock.reset();
  write_labels(made.run.labels(), without);
  EXPECT_NE(test::error_of([&] { start_by(rows); }).find("its video clock is unknown; expected times of the origin first-event"),
            std::string::npos);
}

}  // namespace
}  // namespace tactile::labels
