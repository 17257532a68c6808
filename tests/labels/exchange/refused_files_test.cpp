// Files of other tools that cannot be used: each is answered with what is wrong and what is right.
#include <gtest/gtest.h>

#include "labels/exchange/exported.hpp"
#include "support/error_of.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/labels/exchange/label_csv.hpp"
#include "tactile/labels/exchange/label_studio.hpp"

namespace tactile::labels {
namespace {

class RefusedFiles : public testing::Test {
 protected:
  template <class Read>
  std::string error(const Read& read, const std::string& name, const std::string& text) {
    write_whole(folder / name, text);
    return test::error_of([&] { read(folder / name); });
  }
  void expect(const std::string& error, const std::string& part) { EXPECT_NE(error.find(part), std::string::npos) << error; }
  test::TemporaryFolder folder;
};

TEST_F(RefusedFiles, OfLabelStudio) {
  const auto read = [&](const std::string& text) { return error(read_label_studio, "tasks.json", text); };
  const auto task = [](const std::string& result) {
    return R"([{"data": {"run": "fan/01"}, "annotations": [{"result": [{"id": "press-1", "type": "timeserieslabels", "value": )" +
           result + "}]}]}]";
  };
  expect(read("["), "tasks.json: is not JSON");
  expect(read("[]"), "has no task");
  expect(read(R"([{"run": "fan/01", "label": []}])"),
         "task 1: is not a task; expected Label Studio's export as JSON, not as JSON-MIN");
  expect(read(task(R"({"start": "1.5", "end": 2, "timeserieslabels": ["press"]})")),
         "'fan/01', result 'press-1': 'start' is not a number");
  expect(read(task(R"({"start": 1e300, "end": 2, "timeserieslabels": ["press"]})")), "'start' is 1e+300");
  expect(read(task(R"({"start": 1.5, "end": 2, "timeserieslabels": ["push"]})")), "'push' is not a class");
  expect(read(task(R"({"start": 1.5, "end": 2, "timeserieslabels": ["press", "slip"]})")), "must have one class");
  expect(read(R"([{"data": {"run": "fan/01"}, "annotations": [{"result": []}, {"result": []}]}])"), "has several annotations");
  expect(read(std::string(50, '[')), "nests values more than 20 deep");
  std::string many = "[";
  for (int i = 0; i < 1'000'100; ++i) many += "0,";
  expect(read(many + "0]"), "has more than 1000000 values");
}

TEST_F(RefusedFiles, OfCsv) {
  const auto read = [&](const std::string& text) { return error(read_label_csv, "labels.csv", text); };
  expect(read("run,id\nfan/01,press-1\n"), "labels.csv: no column 'class'");
  expect(read("class,start_s,end_s\npress,0.1\n"), "line 2 has 2 values; expected 3");
  expect(read("class,start_s,end_s\npush,0.1,0.2\n"), "line 2, column 'class' holds 'push'; expected press, slip, or none");
  expect(read("class,start_s,end_s\npress,NaN,0.2\n"), "line 2, column 'start_s' holds 'NaN'; expected seconds");
  expect(read("class,start_s,end_s,confirmed\npress,0.1,0.2,maybe\n"),
         "column 'confirmed' holds 'maybe'; expected true or false");
  expect(read("class,start_s,end_s,origin\npress,0.1,0.2,dawn\n"), "column 'origin' holds 'dawn'");
  expect(read("class,start_s,end_s,run,origin\npress,0.1,0.2,fan/01,camera\nslip,0.3,0.4,fan/01,video\n"),
         "line 3: the times of 'fan/01' have another origin");
  expect(read("class,start_s,end_s\n"), "has no row");
  expect(read(std::string(2'000, ',') + "\n"), "no column 'class'");
}

TEST_F(RefusedFiles, ButSpreadsheetsOfAllLandsAreRead) {
  write_whole(folder / "labels.csv",
              "\xEF\xBB\xBFrun;id;class;start_s;end_s;confirmed;flags\r\nfan/01;press-1;Press;0,9296;1,5;TRUE;\"odd; "
              "\"\"very\"\"\nodd\"\r\n\r\n");
  const std::vector<ImportedLabels> read = read_label_csv(folder / "labels.csv");
  ASSERT_EQ(read.size(), 1U);
  ASSERT_EQ(read[0].intervals.size(), 1U);
  EXPECT_EQ(read[0].intervals[0].touch, Touch::press);
  EXPECT_EQ(read[0].intervals[0].start_us, 929'600);
  EXPECT_EQ(read[0].intervals[0].start_rounding_us, 50);
  EXPECT_TRUE(read[0].intervals[0].confirmed);
}

TEST_F(RefusedFiles, AnIdThatAToolWouldLoseIsNotWritten) {
  for (const char* id : {"my press", "press-1#2", "1", "", "a\tb"}) {
    LabelsToExport run = test::exported_run();
    run.labels.intervals[0].id = id;
    expect(test::error_of([&] { label_csv_text(std::vector{run}); }), "cannot be kept in other tools");
  }
}

}  // namespace
}  // namespace tactile::labels
