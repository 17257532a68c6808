#include "tactile/results/cell.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "support/error_of.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::results {
namespace {

std::vector<Cell> two_cells() {
  Cell first{{"fan", "02", 1}};
  first.world = "7001";
  first.setting = "stream, 2 ms";
  first.threshold = 1.5;
  first.by_truth = true;
  first.touches = {{Touch::press, DetectionOutcome::detected, 4.25},
                   {Touch::press, DetectionOutcome::missed, 500},
                   {Touch::slip, DetectionOutcome::detected, 3.5, -17.5},
                   {Touch::slip, DetectionOutcome::early, 310, 290}};
  first.outside_s = 1.25;
  first.in_alarm_s = 0.125;
  first.alarms = {{"firm lift", 2}, {"quiet", 1}};
  first.wrong_class = 3;
  first.first = {250, 240};
  first.before_last = {50, 50};
  first.last = {100, 30};
  first.samples.at(Touch::slip, Touch::press) = 7;
  Cell second{{"mug", "03"}};
  second.confirmed = true;
  second.alarms = {{"after an end", 4}};
  second.false_slips = 0;
  return {first, second};
}

TEST(Cells, AreReadAsTheyWereWritten) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "cells.csv";
  write_whole(file, cells_csv(two_cells()));
  EXPECT_EQ(read_cells(file), two_cells());
}

TEST(Cells, AreATableForOthers) {
  EXPECT_EQ(cells_csv(two_cells()),
            "world,object,run,training,setting,answer,threshold,tick_ms,judged_by,outside_s,in_alarm_s,wrong_class,false_slips,"
            "alarms,alarms_after an end,alarms_firm lift,alarms_quiet,press_ms,slip_ms,gross_slip_ms,first_ticks,first_right,"
            "before_last_ticks,before_last_right,last_ticks,last_right,none_as_none,none_as_press,none_as_slip,press_as_none,"
            "press_as_press,press_as_slip,slip_as_none,slip_as_press,slip_as_slip\n"
            "7001,fan,02,1,\"stream, 2 ms\",touch,1.5,2,truth,1.25,0.125,3,,3,0,2,1,4.25 >500,3.5 early>310,-17.5 "
            ">290,250,240,50,50,100,30,0,0,0,0,0,0,0,7,0\n"
            ",mug,03,0,,confirmed slip,,2,labels,0,0,0,0,4,4,0,0,,,,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0\n");
}

TEST(Cells, OfAnotherFormAreRefused) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "cells.csv";
  write_whole(file, "object,run\nfan,02\n");
  EXPECT_NE(test::error_of([&] { read_cells(file); }).find("cells.csv: no column"), std::string::npos);
  const auto refused = [&](const std::string& what, const std::string& by, const std::string& why) {
    std::string text = cells_csv(two_cells());
    text.replace(text.find(what), what.size(), by);
    write_whole(file, text);
    const std::string error = test::error_of([&] { read_cells(file); });
    EXPECT_NE(error.find(why), std::string::npos) << by << ": " << error;
  };
  refused("4.25 >500", "4.25 late", "delays in ms");
  refused("4.25 >500", "4.25 >inf", "delays in ms");
  refused("-17.5 >290", "-17.5", "as many words");
  refused("-17.5 >290", "-17.5 290", "'>'");
  refused("touch,1.5,2,truth", "touch,1.5,0,truth", "above 0");
  refused("touch,1.5,2,truth", "touch,1.5,2,guess", "truth or labels");
  refused("touch,1.5,2,truth", "hold,1.5,2,truth", "'touch' or 'confirmed slip'");
  refused("truth,1.25", "truth,-1", "0 or more");
  refused(",3,,3,0,2,1,", ",3,,4,0,2,1,", "the sum");
}

TEST(Cells, CountDelaysInTicks) {
  Cell cell;
  const auto delay = [&](double ms) { return cell.delay_ms({Touch::press, DetectionOutcome::detected, ms}); };
  EXPECT_DOUBLE_EQ(delay(0.001), 2);
  EXPECT_DOUBLE_EQ(delay(2), 2) << "an onset at a tick: the first tick after it is the next one";
  EXPECT_DOUBLE_EQ(delay(2.001), 4);
  EXPECT_DOUBLE_EQ(cell.delay_ms({Touch::press, DetectionOutcome::missed, 2.001}), 2.001);
  EXPECT_DOUBLE_EQ(*cell.gross_delay_ms({Touch::slip, DetectionOutcome::detected, 3, -17.5}), -16);
  EXPECT_DOUBLE_EQ(*cell.gross_delay_ms({Touch::slip, DetectionOutcome::missed, 500, 481}), 481);
  EXPECT_FALSE(cell.gross_delay_ms({Touch::slip, DetectionOutcome::detected, 3}));
}

TEST(Cells, SayWhatTheyCount) {
  EXPECT_EQ(
      words_of(two_cells()[0]),
      "By the truth: 3 false alarms in 1.2 s outside of touches (2 firm lift, 1 quiet); in alarm for 10.0 % of that time. 3 "
      "episodes of the wrong class.");
  EXPECT_EQ(words_of(Cell{}), "By the labels: 0 false alarms in 0.0 s outside of touches. 0 episodes of the wrong class.");
}

}  // namespace
}  // namespace tactile::results
