#include "tactile/report/trade_plots.hpp"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <regex>

#include "report/plot_rows.hpp"
#include "report/read_plot.hpp"
#include "support/drawn_plot.hpp"
#include "tactile/core/text_lines.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::report {
namespace {

using test::contains;
using test::drawn;
using test::has_row;
using test::Words;
using test::words_in;
using test::x_axes;
using test::XAxis;

using Row = std::vector<double>;

/// A table row by row.
std::vector<Row> rows_of(const pictures::PlotTable& table) {
  std::vector<Row> rows;
  for (auto at = table.values.begin(); at != table.values.end(); at += static_cast<std::ptrdiff_t>(table.columns))
    rows.emplace_back(at, at + static_cast<std::ptrdiff_t>(table.columns));
  return rows;
}

bool is_row(const Row& a, const Row& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](double x, double y) { return std::abs(x - y) < 1e-9; });
}

/// Labels lie within the axis, and no two of them in each other.
void expect_readable(XAxis axis, std::size_t at_least) {
  constexpr double character = 9, line = 17;  // [px]
  EXPECT_GE(axis.tics.size(), at_least);
  std::sort(axis.tics.begin(), axis.tics.end(), [](const XAxis::Tic& a, const XAxis::Tic& b) { return a.place < b.place; });
  const XAxis::Tic* before = nullptr;
  for (const XAxis::Tic& tic : axis.tics) {
    EXPECT_GE(tic.place, axis.begin) << tic.label;
    EXPECT_LE(tic.place, axis.end) << tic.label;
    if (tic.label.empty()) continue;
    if (before != nullptr) {
      const double room = axis.is_aslant ? line : character * static_cast<double>(before->label.size() + tic.label.size()) / 2;
      EXPECT_GT(axis.px(tic.place) - axis.px(before->place), room) << before->label << " and " << tic.label;
    }
    before = &tic;
  }
}

/// One that costs `us` a tick and alarms `alarms` times a minute, on both fronts.
results::TradedSetting setting(const std::string& text, double us, double accuracy, double alarms, double delay_us) {
  results::TradedSetting made;
  made.text = text;
  made.design = text == "as usual" ? "usual" : "one";
  made.reported.accuracy = {.value = accuracy, .low = accuracy - 0.01, .high = accuracy + 0.01, .n = 9};
  made.reported.us_p99.value = us;
  made.reported.whole_runs.alarms_per_min.value = alarms;
  made.reported.whole_runs.median_ms.ms = {
      .value = delay_us / 1000, .low = delay_us / 1000 - 1, .high = delay_us / 1000 + 2, .n = 9};
  made.on_accuracy_front = made.on_delay_front = true;
  return made;
}

results::TradedSetting beaten(results::TradedSetting setting) {
  setting.on_accuracy_front = setting.on_delay_front = false;
  return setting;
}

results::Trade trade_of(std::vector<results::TradedSetting> settings) {
  results::Trade trade;
  trade.points = std::move(settings);
  return trade;
}

TEST(TradeAccuracyPlot, HoldsPercentAgainstTheLogarithmOfTheTime) {
  const pictures::Plot plot =
      trade_accuracy_plot(trade_of({beaten(setting("as usual", 100, 0.9, 3, 9000)), setting("t_h 2 ms", 1000, 0.95, 30, 5000)}));
  EXPECT_TRUE(has_row(plot, {2, 90}));
  EXPECT_TRUE(has_row(plot, {3, 95, 94, 96}));
  const std::string svg = drawn(plot);
  for (const char* words : {"accuracy [%]", "99th percentile of the time per tick [us]", ">usual<", "t_h 2 ms"})
    EXPECT_TRUE(contains(svg, words)) << words;
}

TEST(TradeAccuracyPlot, LabelsItsTimesThroughoutHoweverFarTheyReach) {
  const auto axis_of = [](double least_us, double most_us) {
    const std::vector<XAxis> axes =
        x_axes(trade_accuracy_plot(trade_of({setting("a", least_us, 0.8, 1, 1000), setting("b", most_us, 0.9, 1, 1000)})));
    EXPECT_EQ(axes.size(), 1U);
    return axes.at(0);
  };
  const XAxis usual = axis_of(18, 670);
  for (const char* label : {"20", "50", "100", "200", "500"}) EXPECT_TRUE(usual.has(label)) << label;
  expect_readable(usual, 5);
  for (const auto& [least, most] : {std::pair(180.0, 190.0), std::pair(185.0, 185.0), std::pair(99.0, 101.0),
                                    std::pair(30.0, 70.0), std::pair(0.4, 9e6), std::pair(1e-3, 1e9)}) {
    SCOPED_TRACE(fmt::format("{:g} to {:g} us", least, most));
    const XAxis axis = axis_of(least, most);
    EXPECT_LT(axis.begin, std::log10(least));
    EXPECT_GT(axis.end, std::log10(most));
    expect_readable(axis, 3);
  }
}

TEST(TradeDelayPlot, IsLinearNearNoAlarmsAndLogarithmicBeyond) {
  const pictures::Plot plot = trade_delay_plot(trade_of(
      {setting("none", 100, 0.9, 0, 9000), setting("few", 100, 0.9, 1, 7000), beaten(setting("many", 100, 0.9, 3999, 5000))}));
  EXPECT_TRUE(has_row(plot, {0, std::log10(10), std::log10(9), std::log10(12)}));
  EXPECT_TRUE(has_row(plot, {std::log10(2), std::log10(8), std::log10(7), std::log10(10)}));
  EXPECT_TRUE(has_row(plot, {std::log10(4000), std::log10(6)}));
  const XAxis axis = x_axes(plot).at(0);
  for (const auto& [label, value] :
       {std::pair("0", 0), std::pair("1", 1), std::pair("3", 3), std::pair("10", 10), std::pair("30", 30), std::pair("100", 100),
        std::pair("1000", 1000), std::pair("3000", 3000)}) {
    const auto is_it = [wanted = std::string(label)](const XAxis::Tic& tic) { return tic.label == wanted; };
    const auto tic = std::find_if(axis.tics.begin(), axis.tics.end(), is_it);
    ASSERT_NE(tic, axis.tics.end()) << label;
    EXPECT_NEAR(tic->place, std::log10(value + 1), 1e-8) << label;
  }
  expect_readable(axis, 8);
  constexpr double mark = 12;  // [px]
  EXPECT_GT(axis.px(std::log10(2)) - axis.px(0), 3 * mark) << "none and one are apart";
}

TEST(TradeDelayPlot, IsLabelledWhateverTheAlarms) {
  for (const auto& [least, most] : {std::pair(0.0, 0.0), std::pair(0.2, 0.4), std::pair(9.0, 9.0), std::pair(60.0, 110.0),
                                    std::pair(500.0, 4000.0), std::pair(0.0, 1e6), std::pair(2000.0, 2000.0)}) {
    SCOPED_TRACE(fmt::format("{:g} to {:g} a minute", least, most));
    const pictures::Plot plot =
        trade_delay_plot(trade_of({setting("a", 100, 0.8, least, 1000), setting("b", 100, 0.9, most, 2000)}));
    const XAxis axis = x_axes(plot).at(0);
    EXPECT_LT(axis.begin, std::log10(least + 1));
    EXPECT_GT(axis.end, std::log10(most + 1));
    expect_readable(axis, 3);
  }
}

TEST(TradePlots, NameTheFrontWholeInLinesThatFit) {
  const std::vector<std::string> knobs{"t_h 2 ms",        "tick 1 ms", "factor 0.1",  "resize linear", "denoise none",
                                       "engine libtorch", "int8",      "confirm 2/3", "dense"};
  std::string name;
  for (const std::string& knob : knobs) name += (name.empty() ? "" : ", ") + knob;
  results::TradedSetting long_one = setting(name, 20, 0.7, 900, 5000);
  long_one.reported.whole_runs.missed.value = 0.125;
  results::TradedSetting other = beaten(setting("stream", 10, 0.8, 5, 9000));  // has less room
  other.reported.whole_runs.missed.value = 0.25;
  const results::Trade trade =
      trade_of({setting("as usual", 200, 0.9, 3, 9000), long_one, beaten(setting("dense", 300, 0.8, 4, 9000)), other});
  for (const pictures::Plot& plot : {trade_accuracy_plot(trade), trade_delay_plot(trade)}) {
    const std::vector<Words> words = words_in(plot);
    for (const std::string& knob : knobs) {
      EXPECT_TRUE(std::any_of(words.begin(), words.end(), [&knob](const Words& line) {
        return line.text.find(knob) != std::string::npos && characters_in(line.text) <= 60;
      })) << knob;
    }
    for (const Words& line : words) {
      EXPECT_FALSE(contains(line.text, "…")) << line.text;
      EXPECT_LE(characters_in(line.text), 114U) << line.text;
      EXPECT_GT(line.y, 0) << line.text;
      EXPECT_LT(line.y, plot.height_px - 6) << line.text;
    }
    EXPECT_TRUE(std::any_of(words.begin(), words.end(), [](const Words& line) { return line.text == "dense"; }));
    drawn(plot);
  }
  const std::string svg = drawn(trade_delay_plot(trade));
  EXPECT_TRUE(contains(svg, "(12.5 % missed or early)"));
  EXPECT_TRUE(contains(svg, "(25.0 % missed or early)"));
}

TEST(TradePlots, NumberTheFrontByWhatIsAcross) {
  const pictures::Plot plot =
      trade_accuracy_plot(trade_of({setting("slow", 300, 0.95, 3, 9000), setting("fast", 30, 0.9, 3, 9000)}));
  const std::vector<Words> words = words_in(plot);
  const auto line = [&words](const std::string& text) {
    return std::find_if(words.begin(), words.end(), [&text](const Words& one) { return one.text == text; });
  };
  const auto one = line("1"), fast = line("fast"), two = line("2"), slow = line("slow");
  for (const auto& found : {one, fast, two, slow}) ASSERT_NE(found, words.end());
  EXPECT_DOUBLE_EQ(one->y, fast->y) << "the list's numbers come first";
  EXPECT_DOUBLE_EQ(two->y, slow->y);
  // In the panel each is near its mark.
  const XAxis axis = x_axes(plot).at(0);
  for (const auto& [number, us] : {std::pair("1", 30.0), std::pair("2", 300.0)}) {
    const auto is_beside = [&axis, wanted = std::string(number), us = us](const Words& label) {
      return label.text == wanted && std::abs(label.x - axis.px(std::log10(us))) < 30;
    };
    EXPECT_TRUE(std::any_of(words.begin(), words.end(), is_beside)) << number;
  }
}

TEST(TradePlots, ShowTheFrontByFilledMarksAndJoinItByNoLine) {
  results::Trade trade = trade_of(
      {beaten(setting("as usual", 100, 0.9, 3, 9000)), setting("fast", 10, 0.8, 9, 9000), setting("sure", 1000, 0.95, 1, 9000)});
  for (const bool has_intervals : {true, false}) {
    for (const pictures::Plot& plot : {trade_accuracy_plot(trade), trade_delay_plot(trade)}) {
      EXPECT_FALSE(contains(plot.script, "with lines"));
      std::smatch drawing;
      // Tables of the others, of the front and of the usual setting, each with a mark of its own.
      ASSERT_TRUE(std::regex_search(plot.script, drawing,
                                    std::regex(R"(plot \$(t\d+) .*? pt 6 .*?, \$(t\d+) .*? pt 7 .*?, \$(t\d+) .*? pt 12 )")));
      const auto rows = [&](std::size_t group) {
        const auto table = std::find_if(plot.tables.begin(), plot.tables.end(),
                                        [&](const pictures::PlotTable& one) { return one.name == drawing[group].str(); });
        return table == plot.tables.end() ? std::vector<Row>() : rows_of(*table);
      };
      EXPECT_EQ(rows(1).size(), 1U);
      EXPECT_EQ(rows(2).size(), 2U);
      ASSERT_EQ(rows(3).size(), 1U);
      EXPECT_TRUE(is_row(rows(3)[0], rows(1)[0])) << "the usual one has its diamond around its circle";
      const std::string svg = drawn(plot);
      EXPECT_TRUE(contains(svg, "on the front of"));
      EXPECT_EQ(contains(svg, "95 %"), has_intervals) << "intervals are spoken of only where there are some";
      for (const Row& row : rows(2)) EXPECT_EQ(row[2] < row[1] && row[1] < row[3], has_intervals);
    }
    for (results::TradedSetting& one : trade.points) {
      for (results::Figure* measured : {&one.reported.accuracy, &one.reported.whole_runs.median_ms.ms})
        measured->low = measured->high = std::nullopt;
    }
  }
}

TEST(TradePlots, KeepNumbersApartInACrowdAndCountThoseWithoutOne) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> some(-1, 1);
  std::vector<results::TradedSetting> settings{setting("as usual", 100, 0.9, 3, 9000)};
  for (int i = 1; i < 30; ++i)
    settings.push_back(setting(fmt::format("factor {}", i), 100 + 30 * some(random), 0.9 + 0.05 * some(random), 3, 9000));
  settings.push_back(beaten(setting("far", 900, 0.5, 3, 9000)));
  const pictures::Plot plot = trade_accuracy_plot(trade_of(settings));
  drawn(plot);
  std::vector<Words> numbers;
  const std::vector<Words> words = words_in(plot);
  std::string all;
  for (const Words& line : words) all += line.text + ' ';
  EXPECT_TRUE(contains(all, "The first 24 of 30 on the front are numbered."));
  const auto list_begin = std::find_if(words.begin(), words.end(), [](const Words& line) { return line.text == "25"; });
  ASSERT_NE(list_begin, words.end());
  std::copy_if(list_begin + 1, words.end(), std::back_inserter(numbers),
               [](const Words& line) { return std::regex_match(line.text, std::regex("[0-9]+")); });
  ASSERT_EQ(numbers.size(), 25U) << "of the front, and of the one that is far off";
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const double width = 8.0 * static_cast<double>(numbers[i].text.size() + numbers[k].text.size()) / 2;
      EXPECT_TRUE(std::abs(numbers[i].x - numbers[k].x) >= width || std::abs(numbers[i].y - numbers[k].y) >= 13)
          << numbers[i].text << " and " << numbers[k].text;
    }
  }
}

TEST(TradePlots, NumberThoseOnNoFrontTooAndOnceWhereTheyMeet) {
  const pictures::Plot plot =
      trade_accuracy_plot(trade_of({beaten(setting("as usual", 100, 0.9, 3, 9000)), setting("fast", 10, 0.8, 9, 9000),
                                    beaten(setting("dense", 500, 0.85, 3, 9000)), beaten(setting("int8", 300, 0.7, 3, 9000)),
                                    beaten(setting("confirm 2/3", 500.1, 0.85, 3, 9000))}));
  const std::vector<Words> words = words_in(plot);
  const auto place_of = [&words](const std::string& text) {
    const auto found = std::find_if(words.begin(), words.end(), [&text](const Words& one) { return one.text == text; });
    EXPECT_NE(found, words.end()) << text;
    return found == words.end() ? Words{} : *found;
  };
  // In the list, from left to right in the panel.
  for (const auto& [number, name] : {std::pair("2", "int8"), std::pair("3", "dense"), std::pair("4", "confirm 2/3")})
    EXPECT_DOUBLE_EQ(place_of(number).y, place_of(name).y) << name;
  const XAxis axis = x_axes(plot).at(0);
  EXPECT_LT(std::abs(place_of("3–4").x - axis.px(std::log10(500))), 60);
  EXPECT_LT(std::abs(place_of("usual").x - axis.px(2)), 60);
  drawn(plot);
}

TEST(TradePlots, OfTooManyNumberThoseThatTurnOneKnobFirst) {
  std::vector<results::TradedSetting> settings{setting("as usual", 100, 0.9, 3, 9000)};
  for (int i = 0; i < 100; ++i)
    settings.push_back(beaten(setting(fmt::format("int8, factor {}", i), 120 + 5 * i, 0.5 + 0.003 * i, 3, 9000)));
  settings.push_back(beaten(setting("dense", 700, 0.6, 3, 9000)));
  const pictures::Plot plot = trade_accuracy_plot(trade_of(settings));
  std::string all;
  for (const Words& line : words_in(plot)) all += line.text + '\n';
  EXPECT_TRUE(contains(all, "Without a number: 59 more."));
  EXPECT_TRUE(contains(all, "\ndense\n"));
  drawn(plot);
}

TEST(TradePlots, BearFewSettingsAndWhatIsMissing) {
  const results::TradedSetting usual = setting("as usual", 186, 0.9, 9, 14'000);
  results::TradedSetting silent = setting("denoise none", 120, 0.6, 2, NAN), unknown = setting("int8", NAN, NAN, NAN, 5000);
  silent.reported.whole_runs.median_ms.ms = {};
  using Settings = std::vector<results::TradedSetting>;
  for (const auto& make : {trade_accuracy_plot, trade_delay_plot}) {
    const std::string nothing = drawn(make(trade_of({})));
    EXPECT_TRUE(contains(nothing, "nothing to show"));
    EXPECT_FALSE(contains(nothing, "front")) << "none is spoken of where there is none";
    EXPECT_TRUE(contains(drawn(make(trade_of({unknown}))), "Not shown, without a value: 1."));
    for (const Settings& settings :
         {Settings{usual}, Settings{beaten(usual)}, Settings{usual, usual}, Settings{usual, setting("best", 1, 1.0, 0, 0)}}) {
      const pictures::Plot plot = make(trade_of(settings));
      const std::string svg = drawn(plot);
      EXPECT_TRUE(contains(svg, "the usual setting"));
      EXPECT_TRUE(contains(svg, ">usual<") || settings.size() > 1) << "in a crowd there may be no room for it";
      EXPECT_FALSE(contains(plot.script, "nothing to show"));
      EXPECT_FALSE(contains(plot.script, "Not shown"));
      expect_readable(x_axes(plot).at(0), 3);
    }
  }
  EXPECT_FALSE(contains(trade_accuracy_plot(trade_of({usual, silent})).script, "Not shown"));
  EXPECT_TRUE(contains(trade_delay_plot(trade_of({usual, silent})).script, "Not shown, without a value: 1."));
}

}  // namespace
}  // namespace tactile::report
