#include "trade_text.hpp"

#include <fmt/core.h>

#include <cmath>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "tactile/core/duration_units.hpp"
#include "tactile/core/text_lines.hpp"
#include "tactile/pictures/plot_script.hpp"
#include "tactile/results/figure_text.hpp"
#include "text_table.hpp"

namespace tactile::cli {
namespace {

std::string number_text(double value, int decimals) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, decimals) : "-";
}

/// "87", with a star on the front itself; "-" if it is unknown.
std::string probability_text(const std::optional<double>& share, bool is_on_front) {
  return number_text(100 * share.value_or(NAN), 0) + (is_on_front ? "*" : " ");
}

std::string settings_text(const results::Trade& trade) {
  constexpr std::size_t most_rows = 60, width_of_setting = 12;
  std::vector<std::vector<std::string>> rows;
  std::size_t more = 0;
  for (const results::TradedSetting& point : trade.points) {
    if (rows.size() >= most_rows && !point.on_accuracy_front && !point.on_delay_front) {
      ++more;
      continue;
    }
    const results::TradeResult& figures = point.reported;
    const std::vector<std::string> words = lines_of(wrapped(point.text, 0, width_of_setting));
    rows.push_back({words.front(), probability_text(point.front_probability.accuracy, point.on_accuracy_front),
                    probability_text(point.front_probability.delay, point.on_delay_front),
                    results::figure_text(figures.accuracy, 100, 1), results::value_text(figures.whole_runs.median_ms, 1),
                    results::value_text(figures.whole_runs.p90_ms), results::value_text(figures.whole_runs.missed, 100, 0),
                    results::value_text(figures.whole_runs.alarms_per_min, 1, 1), results::value_text(figures.us_p50, 1, 0),
                    results::value_text(figures.us_p99, 1, 0), results::value_text(figures.us_p999, 1, 0)});
    for (std::size_t i = 1; i < words.size(); ++i) {
      rows.emplace_back(rows.back().size());
      rows.back().front() = words[i];
    }
  }
  std::string text =
      text_table({"setting", "A [%]", "D [%]", "accuracy [%]", "delay", "p90", "missed", "alarms", "p50", "p99", "p99.9"}, rows);
  if (more > 0) text += fmt::format("and {} more settings, on no front\n", more);
  return text + "\n";
}

/// The point for which a figure of the reported runs is best among those that suit; null if there is none.
const results::TradedSetting* best_point(const results::Trade& trade,
                                         const std::function<bool(const results::TradedSetting&)>& suits,
                                         const std::function<double(const results::TradeResult&)>& badness) {
  const results::TradedSetting* best = nullptr;
  for (const results::TradedSetting& point : trade.points) {
    const double bad = badness(point.reported);
    if (suits(point) && std::isfinite(bad) && (best == nullptr || bad < badness(best->reported))) best = &point;
  }
  return best;
}

/// The usual setting, the recommended one, and the ends of both fronts: a row for each.
std::string ends_of_fronts(const results::Trade& trade) {
  using Setting = results::TradedSetting;
  using Figures = results::TradeResult;
  const auto on_front = [](bool Setting::*front) { return [front](const Setting& point) { return point.*front; }; };
  const auto is_recommended = [&](const Setting& point) { return point.id == trade.recommendation.id; };
  const auto by_accuracy = on_front(&Setting::on_accuracy_front), by_delay = on_front(&Setting::on_delay_front);
  const std::vector<std::pair<std::string, const Setting*>> chosen{
      {"usual", &trade.points.front()},
      {"recommended", best_point(trade, is_recommended, [](const Figures&) { return 0.0; })},
      {"most accurate", best_point(trade, by_accuracy, [](const Figures& figures) { return -figures.accuracy.value; })},
      {"fastest", best_point(trade, by_accuracy, [](const Figures& figures) { return figures.us_p99.value; })},
      {"fewest alarms",
       best_point(trade, by_delay, [](const Figures& figures) { return figures.whole_runs.alarms_per_min.value; })}};
  std::vector<std::vector<std::string>> rows;
  for (const auto& [name, point] : chosen) {
    if (point == nullptr) continue;
    const Figures& figures = point->reported;
    constexpr std::size_t widest = 26;
    rows.push_back({name, pictures::shortened(point->text, widest), results::value_text(figures.accuracy, 100, 1),
                    results::value_text(figures.whole_runs.median_ms, 1),
                    results::value_text(figures.whole_runs.alarms_per_min, 1, 1), results::value_text(figures.us_p99, 1, 0)});
  }
  return text_table({"", "setting", "acc. [%]", "delay [ms]", "alarms/min", "p99 [us]"}, rows);
}

/// Up to the first full stop.
std::string first_sentence(const std::string& text) {
  const std::size_t end = text.find(". ");
  return end == std::string::npos ? text : text.substr(0, end + 1);
}

}  // namespace

std::string short_trade_text(const trade::TradeSummary& summary) {
  const results::Trade& trade = summary.trade;
  std::string text = wrapped(trade.title) + "\n\n" + ends_of_fronts(trade) + "\n" +
                     wrapped(first_sentence(trade.recommendation.sentence)) + "\n";
  text += fmt::format("Other programs interrupted {:.2g} % of the timed ticks.\n", 100 * trade.interrupted);
  if (!trade.unfinished.empty()) text += wrapped(first_sentence(trade.unfinished)) + "\n";
  return text + fmt::format("{} settings; {} steps done, {} kept; --verbose prints all. Written to {}\n", trade.points.size(),
                            summary.done, summary.kept, summary.file.string());
}

std::string full_trade_text(const trade::TradeSummary& summary) {
  const results::Trade& trade = summary.trade;
  std::string text =
      trade.title + "\n\n" + wrapped(trade.times_are) + "\n\n" + wrapped(trade.judged_by) + "\n\n" +
      wrapped(
          "Of each setting: accuracy with its 95 % interval, median and 90 % quantile of the delay of presses and slips [ms] "
          "(one "
          "that is missed or early is later than all others), share missed or early [%], false alarms per minute "
          "outside of touches, time per tick [us]. A: probability of being on the front of accuracy and time, with trainings, "
          "objects and runs drawn again; a star: on the front. D: the same for delay, misses and false alarms. Fronts are found "
          "on the runs to choose on. All other figures are of the runs to report on.") +
      "\n\n" + settings_text(trade);
  if (!trade.left_out.empty()) {
    std::string list;
    for (const results::UntriedPair& pair : trade.left_out)
      list += fmt::format("{}{:g}/{:g}", list.empty() ? "" : ", ", in_ms(pair.history), in_ms(pair.tick));
    text +=
        wrapped(fmt::format("Left out, because the history is not a whole number of ticks (t_h/tick in ms): {}.", list)) + "\n";
  }
  for (const results::NotMeasured& one : trade.not_measured)
    text += wrapped(fmt::format("Not measured: {}: {}.", one.setting, one.why)) + "\n";
  if (!trade.unfinished.empty()) text += "\n" + wrapped(trade.unfinished) + "\n";
  text += "\n" + wrapped(trade.recommendation.sentence) + "\n\n";
  text += fmt::format("{} steps done, {} kept. Written to {}\n", summary.done, summary.kept, summary.file.string());
  return text;
}

}  // namespace tactile::cli
