#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "labels/exchange/exported.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/labels/exchange/import_edits.hpp"
#include "tactile/labels/exchange/label_csv.hpp"
#include "tactile/labels/exchange/label_studio.hpp"

namespace tactile::labels {
namespace {

/// Every format, with times from each origin that it can hold.
class RoundTrip : public testing::TestWithParam<std::pair<ExchangeFormat, TimeOrigin>> {
 protected:
  std::filesystem::path file() const { return folder_ / ("labels" + std::string(ending_of(GetParam().first))); }

  LabelsToExport run() const {
    LabelsToExport run = GetParam().second == TimeOrigin::video ? test::exported_on_film() : test::exported_run();
    run.times.origin = GetParam().second;
    for (LabelledInterval& interval : run.labels.intervals) interval.confirmed = true;
    return run;
  }

  ImportedLabels through_file(const LabelsToExport& run) const {
    const std::vector<LabelsToExport> runs{run};
    switch (GetParam().first) {
      case ExchangeFormat::label_studio:
        write_whole(file(), label_studio_text(runs));
        return read_label_studio(file()).at(0);
      case ExchangeFormat::csv:
        write_whole(file(), label_csv_text(runs));
        return read_label_csv(file()).at(0);
    }
    return {};
  }

 private:
  test::TemporaryFolder folder_;
};

TEST_P(RoundTrip, KeepsRunOriginIdsClassesAndMarks) {
  const LabelsToExport run = this->run();
  const ImportedLabels read = through_file(run);
  EXPECT_EQ(read.run, "fan/01");
  ASSERT_TRUE(read.times.has_value());
  EXPECT_EQ(read.times->origin, run.times.origin);
  EXPECT_EQ(read.times->to_camera(run.first_event).offset_us, run.times.to_camera(run.first_event).offset_us);
  EXPECT_EQ(read.times->to_camera(run.first_event).drift_ppm, run.times.to_camera(run.first_event).drift_ppm);
  ASSERT_EQ(read.intervals.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(read.intervals[i].id, run.labels.intervals[i].id);
    EXPECT_EQ(read.intervals[i].touch, run.labels.intervals[i].touch);
    EXPECT_TRUE(read.intervals[i].confirmed);
  }
}

TEST_P(RoundTrip, LeavesEveryMicrosecondAsItWas) {
  const LabelsToExport run = this->run();
  const ImportedLabels read = through_file(run);
  EditCounts counts;
  const Labels after = with_edits(run.labels, read, *read.times, run.first_event, run.last_event, counts);
  EXPECT_EQ(counts.kept, 3U);
  EXPECT_EQ(counts.edits(), 0U);
  ASSERT_EQ(after.intervals.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    const LabelledInterval& before = run.labels.intervals[i];
    EXPECT_EQ(after.intervals[i].start.at, before.start.at);
    EXPECT_EQ(after.intervals[i].start.low, before.start.low);
    EXPECT_EQ(after.intervals[i].end.at, before.end.at);
    EXPECT_EQ(after.intervals[i].end.high, before.end.high);
    EXPECT_EQ(after.intervals[i].source, "events");
    EXPECT_EQ(after.intervals[i].evidence.robot, before.evidence.robot);
  }
}

INSTANTIATE_TEST_SUITE_P(AllFormats, RoundTrip,
                         testing::Values(std::pair(ExchangeFormat::label_studio, TimeOrigin::first_event),
                                         std::pair(ExchangeFormat::label_studio, TimeOrigin::camera),
                                         std::pair(ExchangeFormat::label_studio, TimeOrigin::video),
                                         std::pair(ExchangeFormat::csv, TimeOrigin::first_event),
                                         std::pair(ExchangeFormat::csv, TimeOrigin::camera),
                                         std::pair(ExchangeFormat::csv, TimeOrigin::video)),
                         [](const auto& parameters) {
                           std::string name =
                               std::string(name_of(parameters.param.first)) + "_" + std::string(name_of(parameters.param.second));
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST(TimesOfAFile, LackIfItCountsFromTheFilmAndDoesNotSayWhenThatBegan) {
  const test::TemporaryFolder folder;
  const auto csv = [&](const std::string& text) {
    write_whole(folder / "labels.csv", text);
    return read_label_csv(folder / "labels.csv").at(0);
  };
  const auto task = [&](const std::string& data) {
    write_whole(folder / "tasks.json", R"([{"data": {"run": "fan/01", )" + data + "}}]");
    return read_label_studio(folder / "tasks.json").at(0);
  };
  for (const ImportedLabels& read :
       {csv("class,start_s,end_s,origin\npress,1.5,1.6,video\n"),
        csv("class,start_s,end_s,origin,zero_s\npress,1.5,1.6,video,\n"), task(R"("origin": "video")")}) {
    EXPECT_EQ(read.origin, TimeOrigin::video);
    EXPECT_FALSE(read.times.has_value());
  }
  for (const ImportedLabels& read :
       {csv("class,start_s,end_s,origin\npress,1.5,1.6,first-event\n"), task(R"("origin": "first-event")")})
    EXPECT_TRUE(read.times.has_value());
  // A row that a person adds below those of the export.
  const ImportedLabels added =
      csv("class,start_s,end_s,origin,zero_s\npress,1.5,1.6,video,-1.2\nslip,1.7,1.8,video,\npress,1.9,2,,\n");
  ASSERT_TRUE(added.times.has_value());
  EXPECT_EQ(added.times->zero_us, -1'200'000);
}

TEST(SecondsText, IsExactForEveryMicrosecondAndReadsBack) {
  EXPECT_EQ(seconds_text(0), "0.000000");
  EXPECT_EQ(seconds_text(-250), "-0.000250");
  EXPECT_EQ(seconds_text(1'710'534'882'413'934), "1710534882.413934");
  for (const std::int64_t us : {std::numeric_limits<std::int64_t>::min(), std::int64_t{-1}, std::int64_t{929'637},
                                std::numeric_limits<std::int64_t>::max()}) {
    const auto read = seconds_in(seconds_text(us));
    ASSERT_TRUE(read.has_value()) << us;
    EXPECT_EQ(read->us, us);
    EXPECT_EQ(read->rounding_us, 1);
  }
}

TEST(SecondsIn, RoundsWithItsResolutionAndRefusesOtherTexts) {
  EXPECT_EQ(seconds_in("0.9296")->rounding_us, 50);
  EXPECT_EQ(seconds_in("0.93")->rounding_us, 500);
  EXPECT_EQ(seconds_in("2")->us, 2'000'000);
  EXPECT_EQ(seconds_in("0,5")->us, 500'000);
  EXPECT_EQ(seconds_in("-1.0000005")->us, -1'000'001);
  for (const char* text :
       {"", "-", ".", "nan", "inf", "1e3", "0x10", "1.2.3", " 1", "1 s", "9223372036854.775808", "99999999999999999999"})
    EXPECT_FALSE(seconds_in(text).has_value()) << text;
}

}  // namespace
}  // namespace tactile::labels
