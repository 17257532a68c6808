#include "tactile/events/event_csv.hpp"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <limits>

#include "events/made_recording.hpp"
#include "support/paths.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::events {
namespace {

using test::event_at;

std::vector<Event> events_in_csv(const std::string& text, const EventCsvOptions& options = {},
                                 std::optional<SensorSize> size = std::nullopt) {
  const test::TemporaryFolder folder;
  write_whole(folder / "events.csv", text);
  EventCsvReader reader(folder / "events.csv", size, options);
  std::vector<Event> events;
  for (auto chunk = reader.next(); !chunk.empty(); chunk = reader.next()) events.insert(events.end(), chunk.begin(), chunk.end());
  return events;
}

/// What reading the text throws, from the line number on.
std::string error_of(const std::string& text, const EventCsvOptions& options = {},
                     std::optional<SensorSize> size = std::nullopt) {
  try {
    events_in_csv(text, options, size);
  } catch (const Error& e) {
    const std::string what = e.what();
    return what.substr(what.find("events.csv:") + 11);
  }
  return "no error";
}

std::string csv_of(const std::vector<std::int64_t>& stamps) {
  std::string text = "t,x,y,p\n";
  for (const std::int64_t stamp : stamps) text += fmt::format("{},1,2,1\n", stamp);
  return text;
}

TEST(EventCsvWriter, WritesOneEventALine) {
  const test::TemporaryFolder folder;
  EventCsvWriter writer(folder / "events.csv");
  writer.write(std::vector{event_at(-5, 0, 0, 0), event_at(1'605'537'493'718'345, 639, 479, 1)});
  writer.close();
  EXPECT_EQ(read_text(folder / "events.csv"), "t_us,x,y,on\n-5,0,0,0\n1605537493718345,639,479,1\n");
}

TEST(EventCsvWriter, HasRoomForTheLongestNumbers) {
  const test::TemporaryFolder folder;
  const std::vector<Event> events(100'000, event_at(std::numeric_limits<std::int64_t>::min(), 32'767, 32'767));
  EventCsvWriter writer(folder / "events.csv");
  writer.write(events);
  writer.close();
  EXPECT_EQ(std::filesystem::file_size(folder / "events.csv"),
            12 + 100'000 * std::string("-9223372036854775808,32767,32767,1\n").size());
}

TEST(EventCsvWriter, CountsStepsBackInTime) {
  const test::TemporaryFolder folder;
  EventCsvWriter writer(folder / "events.csv");
  writer.write(std::vector{event_at(10), event_at(9), event_at(9), event_at(8)});
  EXPECT_EQ(writer.steps_back(), 2U);
}

TEST(EventCsvWriter, NamesAPlaceItCannotWriteTo) { EXPECT_THROW(EventCsvWriter("/no/such/folder/events.csv"), Error); }

TEST(EventCsvReader, ReadsWhatTheWriterWroteAcrossChunks) {
  const test::TemporaryFolder folder;
  const std::vector<Event> events = test::steady_events(200'000, 1'605'537'493'718'345, 3, {640, 480});
  EventCsvWriter writer(folder / "events.csv");
  writer.write(events);
  writer.close();
  EventCsvReader reader(folder / "events.csv", SensorSize{640, 480});
  std::vector<Event> read;
  int chunks = 0;
  for (auto chunk = reader.next(); !chunk.empty(); chunk = reader.next(), ++chunks)
    read.insert(read.end(), chunk.begin(), chunk.end());
  EXPECT_EQ(read, events);
  EXPECT_GT(chunks, 3);
  EXPECT_EQ(reader.bytes_read(), std::filesystem::file_size(folder / "events.csv"));
}

TEST(EventCsvReader, TakesCrLfAMarkOfByteOrderAndALastLineWithoutEnd) {
  const std::vector<Event> expected{event_at(1, 2, 3, 0), event_at(1, 4, 5, 1)};
  EXPECT_EQ(events_in_csv("t_us,x,y,on\r\n1,2,3,0\r\n1,4,5,1\r\n"), expected);
  EXPECT_EQ(events_in_csv("\xEF\xBB\xBFt_us,x,y,on\n1,2,3,0\n1,4,5,1"), expected);
  EXPECT_TRUE(events_in_csv("t_us,x,y,on\n").empty());
}

TEST(EventCsvReader, ReadsTimesAtTheEndsOfTheClock) {
  const auto events = events_in_csv("t_us,x,y,on\n-9223372036854775808,0,0,1\n9223372036854775807,0,0,1\n");
  EXPECT_EQ(us_of(events.at(0).t), std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(us_of(events.at(1).t), std::numeric_limits<std::int64_t>::max());
}

TEST(EventCsvReader, NamesTheLineTheFaultAndTheRemedy) {
  const std::string head = "t_us,x,y,on\n1,2,3,1\n";
  EXPECT_EQ(error_of(head + "2,3,1\n"), "3: '2,3,1' does not have 4 cells; expected the columns 't_us,x,y,on'");
  EXPECT_EQ(error_of(head + "2,3,4,1,9\n"), "3: '2,3,4,1,9' does not have 4 cells; expected the columns 't_us,x,y,on'");
  EXPECT_EQ(error_of(head + "\n"), "3: the line is empty; expected an event, the columns 't_us,x,y,on'");
  EXPECT_EQ(error_of(head + "2s,3,4,1\n"), "3: t_us is '2s'; expected a time in us");
  EXPECT_EQ(error_of(head + "9223372036854775808,3,4,1\n"), "3: t_us is '9223372036854775808'; expected a time in us");
  EXPECT_EQ(error_of(head + "2,3.5,4,1\n"), "3: x is '3.5'; expected a whole number from 0 to 32767");
  EXPECT_EQ(error_of(head + "2,-3,4,1\n"), "3: x is '-3'; expected a whole number from 0 to 32767");
  EXPECT_EQ(error_of(head + "2,3,32768,1\n"), "3: y is '32768'; expected a whole number from 0 to 32767");
  EXPECT_EQ(error_of(head + "2,3,4,2\n"), "3: on is '2'; expected 0 and 1, or -1 and 1");
  EXPECT_EQ(error_of(head + "2,3,4,10\n"), "3: on is '10'; expected 0 and 1, or -1 and 1");
  EXPECT_EQ(error_of(head + "2,3,4,\n"), "3: on is ''; expected 0 and 1, or -1 and 1");
  EXPECT_EQ(error_of(head + "2,3,4,1\n2,640,4,1\n", {}, SensorSize{640, 480}),
            "4: x is '640'; expected a whole number from 0 to 639");
  EXPECT_EQ(error_of(head + "2,3,480,1\n", {}, SensorSize{640, 480}), "3: y is '480'; expected a whole number from 0 to 479");
}

TEST(EventCsvReader, UndoesTheOverflowsOfCounters) {
  for (const auto& [bits, least] : std::vector<std::pair<int, std::int64_t>>{{24, 0}, {31, 0}, {32, 0}, {32, -2'147'483'648}}) {
    const std::int64_t range = std::int64_t{1} << bits, most = least + range;
    const test::TemporaryFolder folder;
    write_whole(folder / "events.csv", csv_of({most - 2, most - 1, least + 100, least + range / 2, most - 7, least}));
    EventCsvReader reader(folder / "events.csv");
    std::vector<std::int64_t> times;
    for (const Event& event : reader.next()) times.push_back(us_of(event.t));
    EXPECT_EQ(times, (std::vector{most - 2, most - 1, most + 100, most + range / 2, most + range - 7, most + range})) << bits;
    EXPECT_EQ(reader.overflows().count, 2U);
    EXPECT_EQ(reader.overflows().line, 4U);
    EXPECT_EQ(reader.overflows().bits, bits);
    EXPECT_EQ(us_of(reader.overflows().before), most - 1);
    EXPECT_EQ(us_of(reader.overflows().after), least + 100);
  }
}

/// What a file of these times is read as, in microseconds.
std::vector<std::int64_t> times_of(const std::vector<std::int64_t>& stamps, const EventCsvOptions& options = {}) {
  std::vector<std::int64_t> times;
  for (const Event& event : events_in_csv(csv_of(stamps), options)) times.push_back(us_of(event.t));
  return times;
}

TEST(EventCsvReader, UndoesAnOverflowInAGap) {
  using Times = std::vector<std::int64_t>;
  constexpr std::int64_t r24 = std::int64_t{1} << 24, r31 = std::int64_t{1} << 31, r32 = std::int64_t{1} << 32;
  for (const auto& [range, gap] : {std::pair(r24, 20'000), std::pair(r24, 500'000), std::pair(r31, 3'000'000),
                                   std::pair(r32, 5'000'000), std::pair(r32, 100'000'000)}) {
    EXPECT_EQ(times_of({range - 1000, gap - 1000}), (Times{range - 1000, range + gap - 1000})) << range;
  }
}

TEST(EventCsvReader, UndoesTheOverflowsOfCountersOfNanoseconds) {
  constexpr std::int64_t r = std::int64_t{1} << 32;
  const EventCsvOptions ns{.columns = "", .time_unit = TimeUnit::ns};
  // No microsecond is lost however often the counter overflows: 2^32 ns are 4294967.296 us.
  EXPECT_EQ(
      times_of({r - 1000, 500, r / 2, r - 1, 0, r / 2, r - 1, 50'000'000}, ns),
      (std::vector<std::int64_t>{4'294'966, 4'294'968, 6'442'451, 8'589'935, 8'589'935, 10'737'418, 12'884'902, 12'934'902}));
  EXPECT_EQ(times_of({(std::int64_t{1} << 31) - 1, 0}, ns), (std::vector<std::int64_t>{2'147'484, 2'147'484}));
  EXPECT_EQ(times_of({1000 * (std::int64_t{1} << 24) - 1000, 1000}, ns), (std::vector<std::int64_t>{16'777'215, 16'777'217}));
}

TEST(EventCsvReader, RefusesRowsOutOfOrderAroundAnOverflow) {
  constexpr std::int64_t r = std::int64_t{1} << 32;
  const std::string remedy =
      " us; expected times that never go back; the counter of 32 bits overflowed in line 3, and sorting would mix the times "
      "before and after it: add 4294967296 us to the times after each overflow, then sort the file";
  EXPECT_EQ(error_of(csv_of({r - 5, 3, r - 2, 7})), "4: time goes back from 4294967299 to 4294967294" + remedy);
  EXPECT_EQ(error_of(csv_of({r - 5, 3000, 2000})), "4: time goes back from 4294970296 to 4294969296" + remedy);
}

TEST(EventCsvReader, DoesNotOfferToSortWhereTimesFallByMostOfARange) {
  EXPECT_EQ(
      error_of(csv_of({10'000'000, 0})),
      "3: time goes back from 10000000 to 0 us; expected times that never go back; if the clock started again here, cut the "
      "file before this line; if a counter of 24 bits overflowed here, in a gap of 6777216 us, add 16777216 us to the times "
      "from this line on");
  for (const std::int64_t before : {16'000'000, 2'000'000'000})
    EXPECT_EQ(error_of(csv_of({before, 0})).find("sort"), std::string::npos) << before;
  EXPECT_NE(error_of(csv_of({4'294'967'297, 0})).find("sort the file"), std::string::npos) << "no counter goes so far";
}

TEST(EventCsvReader, RefusesAClockThatCountsOnPastItsCounter) {
  EXPECT_EQ(
      error_of(csv_of({16'700'000, 0, 16'000'000, 17'000'000})),
      "5: the time 17000000 us is beyond the range of a counter of 24 bits, whose overflow line 3 shows; expected less than "
      "16777216 us; if the clock started again in line 3, cut the file before that line");
}

TEST(EventCsvReader, NamesTheCommandThatSortsRowsOutOfOrder) {
  // Rows of one time keep their order.
  const std::vector<Event> sorted{event_at(2, 7, 3, 0), event_at(9, 4, 5, 1), event_at(9, 1, 1, 1), event_at(10, 6, 6, 1)};
  const test::TemporaryFolder folder;
  std::filesystem::create_directory(folder / "a b");
  const auto file = folder / "a b" / "events.csv";
  const std::vector<std::pair<const char*, EventCsvOptions>> layouts{
      {"t_us,x,y,on\n9,4,5,1\n2,7,3,0\n10,6,6,1\n9,1,1,1\n", {}},
      {"9,4,5,1\n2,7,3,0\n10,6,6,1\n9,1,1,1\n", {.columns = "t,x,y,p"}},
      {"# made by hand\nx\ty\tp\ttime [s]\n4\t5\t1\t9e-6\n7\t3\t0\t0.000002\n6\t6\t1\t1e-5\n1\t1\t1\t0.000009\n", {}},
      {"%geometry:640,480\n# x y p t\n4 5 1  9\n7 3 0 2\n6 6 1 10\n1 1 1 9\n", {}},
      {"p;t;x;y\n1;9;4;5\n-1;2;7;3\n1;10;6;6\n1;9;1;1\n", {}}};
  for (const auto& [text, options] : layouts) {
    write_whole(file, text);
    std::string error;
    try {
      EventCsvReader(file, std::nullopt, options).next();
    } catch (const Error& e) {
      error = e.what();
    }
    const std::string remedy =
        "time goes back from 9 to 2 us; expected times that never go back; if the clock started again here, cut the file before "
        "this "
        "line; if the rows are out of order, to sort the file: ";
    ASSERT_NE(error.find(remedy), std::string::npos) << error;
    const test::CommandResult sort = test::run_shell(error.substr(error.find(remedy) + remedy.size()), folder.path());
    ASSERT_EQ(sort.exit_code, 0) << error << sort.err;
    EXPECT_EQ(events_in_csv(read_text(folder / "sorted.csv"), options), sorted) << read_text(folder / "sorted.csv");
  }
}

TEST(EventCsvReader, ReadsColumnsInAnyOrderByTheirNames) {
  const std::vector<Event> expected{event_at(1, 2, 3, 0), event_at(9, 4, 5, 1)};
  for (const char* text :
       {"x,y,p,t\n2,3,0,1\n4,5,1,9\n", "timestamp, x, y, polarity\n1, 2, 3, 0\n9, 4, 5, 1\n",
        "\"Time [us]\";\"X\";\"Y\";\"Pol\"\n1;2;3;-1\n9;4;5;1\n", "ts\tpolarity\ty\tx\n1\tFalse\t3\t2\n9\tTrue\t5\t4\n",
        "id,t_us,frame,x,y,on,note\n0,1,,2,3,0,first\n1,9,,4,5,1,\n", "%geometry:640,480\n# x y p t\n2 3 0 1\n4 5 1  9\n"}) {
    EXPECT_EQ(events_in_csv(text), expected) << text;
  }
}

TEST(EventCsvReader, ReadsColumnsInTheOrderThatIsGiven) {
  const std::vector<Event> expected{event_at(1, 2, 3, 0), event_at(9, 4, 5, 1)};
  EXPECT_EQ(events_in_csv("1,2,3,0\n9,4,5,1\n", {.columns = "t,x,y,p"}), expected);
  EXPECT_EQ(events_in_csv("a,b,c,d\n1,2,3,0\n9,4,5,1\n", {.columns = "t,x,y,p"}), expected);
  EXPECT_EQ(events_in_csv("%geometry:640,480\n2 7 3 0 1\n4 7 5 1 9\n", {.columns = "x,-,y,polarity,t"}), expected);
  EXPECT_EQ(error_of("1,2,3,0\n"),
            "1: '1,2,3,0' does not name a column of times once; expected a header row such as "
            "'t_us,x,y,on', or --columns with t, x, y and p in the file's order");
  EXPECT_EQ(error_of("1,2,3,0\n", {.columns = "t,x,y"}),
            "1: --columns t,x,y: does not have p once; expected t, x, y and p, and - for one to skip");
  EXPECT_EQ(error_of("1,2,3,0\n", {.columns = "t,x,y,p,q"}),
            "1: --columns t,x,y,p,q: 'q' is no column of events; expected t, x, y and p, and - for one to skip");
  EXPECT_EQ(error_of("1,2,3,0,0\n", {.columns = "t,x,y,p"}),
            "1: --columns t,x,y,p: names 4 columns, but the first row has 5; expected a name or - for each");
}

TEST(EventCsvReader, TakesTheUnitOfTimesFromOptionHeaderOrNumbers) {
  const auto times = [](const std::string& text, const EventCsvOptions& options = {}) {
    std::vector<std::int64_t> result;
    for (const Event& event : events_in_csv(text, options)) result.push_back(us_of(event.t));
    return result;
  };
  using Times = std::vector<std::int64_t>;
  EXPECT_EQ(times("t,x,y,p\n7,0,0,1\n"), Times{7});
  EXPECT_EQ(times("t,x,y,p\n0.0,0,0,1\n-0.0,0,0,1\n1605537493.718345,0,0,1\n"), (Times{0, 0, 1'605'537'493'718'345}));
  EXPECT_EQ(times("t,x,y,p\n1.5e-05,0,0,1\n"), Times{15});
  EXPECT_EQ(times("t_s,x,y,p\n7,0,0,1\n"), Times{7'000'000});
  EXPECT_EQ(times("time (ms),x,y,p\n-1.5,0,0,1\n"), Times{-1'500});
  EXPECT_EQ(times("t_ns,x,y,p\n1605537493718345499,0,0,1\n1605537493718345500,0,0,1\n"),
            (Times{1'605'537'493'718'345, 1'605'537'493'718'346}));
  EXPECT_EQ(times("t_us,x,y,p\n7.0,0,0,1\n", {.time_unit = TimeUnit::ms}), Times{7'000});
  EXPECT_EQ(error_of("t,x,y,p\n7.0,0,0,1\n8.0,0,0,1\n"),
            "1: the first times have a decimal point, but no fraction, so their unit is unknown; expected --time-unit s, ms, us "
            "or ns");
  EXPECT_EQ(error_of("t,x,y,p\n1605537493718345000,0,0,1\n"),
            "1: the time 1605537493718345000 is no time in microseconds; expected --time-unit ns, or another unit");
  EXPECT_EQ(error_of("t_s,x,y,p\n1e18,0,0,1\n"), "2: t_s is '1e18'; expected a time in s");
}

TEST(EventCsvReader, RefusesPolaritiesOfTwoKinds) {
  EXPECT_EQ(error_of("t,x,y,p\n1,0,0,1\n2,0,0,0\n3,0,0,-1\n"),
            "4: the polarity is -1, and 0 in a row above; expected 0 and 1, or -1 and 1");
}

TEST(EventCsvReader, RefusesWhatIsNoCsv) {
  EXPECT_THROW(events_in_csv(""), Error);
  EXPECT_NE(error_of("t_us,x,y,on\n" + std::string(std::size_t{3} << 20, '1')).find("longer than"), std::string::npos);
  EXPECT_THROW(events_in_csv(std::string(std::size_t{3} << 20, '\0')), Error);
  EXPECT_THROW(EventCsvReader("/no/such/file.csv"), Error);
  EXPECT_THROW(EventCsvReader{test::data_folder}, Error);
}

}  // namespace
}  // namespace tactile::events
