// What the files look like to readers that know nothing of ours: Python's own csv, json and xml.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "labels/exchange/exported.hpp"
#include "support/run_command.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/labels/exchange/audacity.hpp"
#include "tactile/labels/exchange/elan.hpp"
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

TEST(OtherReaders, FindTheIntervalsInAnAudacityTrack) {
  const test::TemporaryFolder folder;
  write_whole(folder / "labels.txt", audacity_text(test::exported_run()));
  const nlohmann::json rows = python(folder,
                                     "rows = [r for r in csv.reader(open('labels.txt', encoding='utf-8'), delimiter='\\t')]\n"
                                     "print(json.dumps([[float(r[0]), float(r[1]), r[2]] for r in rows]))\n");
  ASSERT_EQ(rows.size(), 4U);
  const nlohmann::json statement = {0.0, 0.0, "# fan/01 from first-event"};
  const nlohmann::json press = {0.929637, 1.067241, "press-1 press 95% ±0.8 ms"};
  EXPECT_EQ(rows[0], statement);
  EXPECT_EQ(rows[1], press);
}

TEST(OtherReaders, FindEveryFieldInTheCsv) {
  const test::TemporaryFolder folder;
  LabelsToExport run = test::exported_run(), empty = test::exported_run();
  run.labels.intervals[2].confirmed = true;
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
  EXPECT_EQ(cell(0, "source"), "events");
  EXPECT_EQ(cell(0, "confirmed"), "false");
  EXPECT_EQ(cell(0, "flags"), "odd, \"very\" odd");
  EXPECT_EQ(cell(0, "origin"), "first-event");
  EXPECT_EQ(cell(2, "confirmed"), "true");
  EXPECT_EQ(cell(3, "run"), "fan/02");
  EXPECT_EQ(cell(3, "class"), "none");
}

TEST(OtherReaders, FindTiersTimesAndTheFilmInAnElanDocument) {
  const test::TemporaryFolder folder;
  LabelsToExport run = test::exported_on_film();
  run.film = folder / "fan/01/video.mp4";
  run.film_begins_us = 0;
  run.labels.intervals[0].confirmed = true;
  run.labels.flags = {{.interval_index = 2, .reason = "weak", .confirmed = false}};
  write_whole(folder / "labels.eaf", elan_text(run, folder / "labels.eaf"));
  const nlohmann::json read = python(folder, R"(
root = xml.parse('labels.eaf').getroot()
slots = {s.get('TIME_SLOT_ID'): int(s.get('TIME_VALUE')) for s in root.iter('TIME_SLOT')}
tiers = {t.get('TIER_ID'): [[a.get('ANNOTATION_ID'), slots[a.get('TIME_SLOT_REF1')], slots[a.get('TIME_SLOT_REF2')], a.find('ANNOTATION_VALUE').text]
                            for a in t.iter('ALIGNABLE_ANNOTATION')] for t in root.iter('TIER')}
media = root.find('HEADER/MEDIA_DESCRIPTOR')
print(json.dumps({'units': root.find('HEADER').get('TIME_UNITS'), 'tiers': tiers, 'media': media.attrib,
                  'order': [c.tag for c in root], 'types': [t.get('LINGUISTIC_TYPE_ID') for t in root.iter('LINGUISTIC_TYPE')],
                  'ids': [a.get('ANNOTATION_ID') for a in root.iter('ALIGNABLE_ANNOTATION')],
                  'properties': {p.get('NAME'): p.text for p in root.iter('PROPERTY')}}))
)");
  const std::string units = read.at("units"), relative = read.at("media").at("RELATIVE_MEDIA_URL"),
                    mime = read.at("media").at("MIME_TYPE"), origin = read.at("properties").at("tactile-origin");
  EXPECT_EQ(units, "milliseconds");
  EXPECT_EQ(relative, "./fan/01/video.mp4");
  EXPECT_EQ(mime, "video/mp4");
  EXPECT_EQ(origin, "video");
  EXPECT_FALSE(read.at("media").contains("TIME_ORIGIN"));
  // 0.929637 s after the first event are 2.132981 s of camera time after the first frame, which the film, 80 ppm slow, counts as
  // 170 us less.
  const nlohmann::json first = {"press-1", 2133, 2270, "press ok"};
  const nlohmann::json doubts = {{"slip-1-doubt", 2688, 3191, "weak"}};
  EXPECT_EQ(read.at("tiers").at("touch").at(0), first);
  EXPECT_EQ(read.at("tiers").at("touch").size(), 3U);
  EXPECT_EQ(read.at("tiers").at("doubts"), doubts);
  const std::set<std::string> ids = read.at("ids");
  EXPECT_EQ(ids.size(), read.at("ids").size());
}

TEST(OtherReaders, PlayTheFilmFromWhereAnElanDocumentBegins) {
  const test::TemporaryFolder folder;
  LabelsToExport run = test::exported_run();
  run.film = folder / "video.mp4";
  run.film_begins_us = -1'203'344;
  write_whole(folder / "labels.eaf", elan_text(run, folder / "labels.eaf"));
  const nlohmann::json origin =
      python(folder, "print(json.dumps(xml.parse('labels.eaf').getroot().find('HEADER/MEDIA_DESCRIPTOR').get('TIME_ORIGIN')))\n");
  EXPECT_EQ(origin.get<std::string>(), "1203");
  run.film_begins_us = 900'000;
  EXPECT_EQ(elan_text(run, folder / "labels.eaf").find("MEDIA_DESCRIPTOR"), std::string::npos);
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
