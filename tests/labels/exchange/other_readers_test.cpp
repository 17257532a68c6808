// What the files look like to readers that know nothing of ours: Python's own csv, json and xml.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "labels/exchange/exported.hpp"
#include "support/run_command.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/labels/exchange/label_csv.hpp"
#include "tactile/labels/exchange/label_studio.hpp"

namespace tactile::labels {
namespace {

/// What a script prints as JSON, run in `folder`.
nlohmann::json python(const test::TemporaryFolder& folder, const std::string& script) {
  write_whole(folder / "script.py", "import csv, json, xml.etree.ElementTree as xml\n" + script);
  const test::CommandResult result = test::run_shell("/usr/bin/python3 script.py", folder.path());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  return nlohmann::json::parse(result.out, nullptr, false);
}

TEST(OtherReaders, FindEveryFieldInTheCsv) {
  const test::TemporaryFolder folder;
  LabelsToExport run = test::exported_run(), empty = test::exported_run();
  run.labels.intervals[2].confirmed = true;
  run.labels.intervals[0].probability = 0.9825;
  run.labels.intervals[0].visible = after(run.labels.intervals[0].start.at, 4ms);
  run.labels.flags = {{.interval_index = 0, .reason = "odd, \"very\" odd", .confirmed = false}};
  empty.run = "fan/02";
  empty.labels.intervals.clear();
  write_whole(folder / "labels.csv", label_csv_text(std::vector{run, empty}));
  const nlohmann::json rows = python(folder, "print(json.dumps(list(csv.DictReader(open('labels.csv')))))\n");
  ASSERT_EQ(rows.size(), 4U);
  const auto cell = [&](std::size_t row, const char* name) { return rows[row].at(name).get<std::string>(); };
  EXPECT_EQ(cell(0, "run"), "fan/01");
  EXPECT_EQ(cell(0, "id"), "press-1");
  EXPECT_EQ(cell(0, "class"), "press");
  EXPECT_EQ(cell(0, "start_s"), "0.929637");
  EXPECT_EQ(cell(0, "start_low_s"), "0.928937");
  EXPECT_EQ(cell(0, "start_high_s"), "0.930537");
  EXPECT_EQ(cell(0, "end_s"), "1.067241");
  EXPECT_EQ(cell(0, "robot_s"), "0.924514");
  EXPECT_EQ(cell(0, "video_s"), "");
  EXPECT_EQ(cell(0, "visible_s"), "0.933637");
  EXPECT_EQ(cell(0, "probability"), "0.9825");
  EXPECT_EQ(cell(1, "probability"), "") << "a person added it";
  EXPECT_EQ(cell(0, "source"), "events");
  EXPECT_EQ(cell(0, "confirmed"), "false");
  EXPECT_EQ(cell(0, "flags"), "odd, \"very\" odd");
  EXPECT_EQ(cell(0, "origin"), "first-event");
  EXPECT_EQ(cell(2, "confirmed"), "true");
  EXPECT_EQ(cell(3, "run"), "fan/02");
  EXPECT_EQ(cell(3, "class"), "none");
}

TEST(OtherReaders, FindPredictionsSignalsAndAConfigurationForLabelStudio) {
  const test::TemporaryFolder folder;
  LabelsToExport run = test::exported_run();
  run.labels.flags = {{.interval_index = {}, .reason = "no robot log", .confirmed = false}};
  run.signals = {{0.0005, 0.0015}, {{"events_per_s", {1000, 2000}}, {"tcp_height_mm", {300.5, 301}}}};
  LabelsToExport answered = test::exported_run();
  answered.run = "fan/02";
  for (LabelledInterval& interval : answered.labels.intervals) interval.confirmed = true;
  const std::vector runs{run, answered};
  write_whole(folder / "tasks.json", label_studio_text(runs));
  write_whole(folder / "tasks.xml", label_studio_config(runs));
  const nlohmann::json read = python(folder, R"(
tasks = json.load(open('tasks.json'))
config = xml.parse('tasks.xml').getroot()
series, labels = config.find('TimeSeries'), config.find('TimeSeriesLabels')
for task in tasks:
    for answer in task['predictions'] + task.get('annotations', []):
        for result in answer['result']:
            assert result['from_name'] == labels.get('name') and result['to_name'] == series.get('name') == labels.get('toName')
            assert result['value']['timeserieslabels'][0] in [l.get('value') for l in labels.iter('Label')]
signals = tasks[0]['data'][series.get('value')[1:]]
print(json.dumps({'tasks': tasks, 'time': signals[series.get('timeColumn')], 'curves': [signals[c.get('column')] for c in series.iter('Channel')]}))
)");
  const nlohmann::json& task = read.at("tasks").at(0);
  EXPECT_FALSE(task.contains("annotations"));
  EXPECT_EQ(task.at("predictions").at(0).at("score"), 0.0);
  const std::string flags = task.at("data").at("flags");
  EXPECT_EQ(flags, "no robot log");
  const nlohmann::json& result = task.at("predictions").at(0).at("result").at(0);
  const std::string id = result.at("id");
  EXPECT_EQ(id, "press-1");
  EXPECT_EQ(result.at("value").at("start"), 0.929637);
  EXPECT_EQ(read.at("tasks").at(1).at("annotations").at(0).at("result").size(), 3U);
  const nlohmann::json time = {0.0005, 0.0015}, curves = {{1000.0, 2000.0}, {300.5, 301.0}};
  EXPECT_EQ(read.at("time"), time);
  EXPECT_EQ(read.at("curves"), curves);
}

}  // namespace
}  // namespace tactile::labels
