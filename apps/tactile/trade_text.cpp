#include "trade_text.hpp"

#include <fmt/core.h>

#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "experiment_output.hpp"
#include "tactile/core/text_lines.hpp"
#include "tactile/pictures/plot_script.hpp"
#include "text_table.hpp"

namespace tactile::cli {
namespace {

double number_or_nan(const nlohmann::json& json) { return json.is_null() ? NAN : json.get<double>(); }

std::string text_of(double value, int decimals) { return std::isfinite(value) ? fmt::format("{:.{}f}", value, decimals) : "-"; }

/// "87", with a star on the front itself; "-" if it is unknown.
std::string probability_text(const nlohmann::json& front, const char* which) {
  return text_of(100 * number_or_nan(front.at("probability").at(which)), 0) + (front.at(which).get<bool>() ? "*" : " ");
}

std::string settings_text(const nlohmann::json& trade) {
  constexpr std::size_t most_rows = 60, width_of_setting = 12;
  std::vector<std::vector<std::string>> rows;
  std::size_t more = 0;
  for (const auto& point : trade.at("points")) {
    const auto& front = point.at("front");
    const bool accuracy_front = front.at("accuracy"), delay_front = front.at("delay");
    if (rows.size() >= most_rows && !accuracy_front && !delay_front) {
      ++more;
      continue;
    }
    const auto &reported = point.at("reported"), &delay = reported.at("delay_us"), &us = reported.at("us");
    const auto value = [](const nlohmann::json& figure, double factor, int decimals) {
      return text_of(factor * number_or_nan(figure.at("value")), decimals);
    };
    const std::vector<std::string> words = lines_of(wrapped(point.at("text"), 0, width_of_setting));
    rows.push_back({words.front(), probability_text(front, "accuracy"), probability_text(front, "delay"),
                    figure_text(reported.at("accuracy"), 100, 1), value(delay.at("median"), 1e-3, 1),
                    value(delay.at("p90"), 1e-3, 0), value(delay.at("missed"), 100, 0),
                    value(reported.at("episodes_per_min"), 1, 1), value(us.at("p50"), 1, 0), value(us.at("p99"), 1, 0),
                    value(us.at("p999"), 1, 0)});
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

std::string growth_text(const nlohmann::json& trade) {
  if (trade.at("growth").is_null()) return {};
  std::string text;
  for (const auto& [key, title] :
       {std::pair("rate", "events/s"), std::pair("history", "t_h [ms]"), std::pair("resolution", "sensor")}) {
    std::vector<std::vector<std::string>> rows;
    for (const auto& point : trade.at("growth").at(key)) {
      const std::string at = std::string(key) == "rate" ? fmt::format("{:.0f}", point.at("events_per_s").get<double>())
                             : std::string(key) == "history"
                                 ? fmt::format("{:g}", point.at("th_ms").get<double>())
                                 : fmt::format("{}x{}", point.at("sensor").at(0).get<int>(), point.at("sensor").at(1).get<int>());
      const double sparse = point.at("sparse").at("p50_us"), dense = point.at("dense").at("p50_us");
      rows.push_back({at, text_of(point.at("sparse").at("rendering_us"), 1), text_of(point.at("sparse").at("network_us"), 1),
                      text_of(sparse, 1), text_of(dense, 1), text_of(dense / sparse, 1)});
    }
    text += text_table({title, "rendering [us]", "network [us]", "a tick [us]", "dense [us]", "times"}, rows) + "\n";
  }
  return "How the cost of a tick grows (medians)\n\n" + text;
}

/// The point for which a figure of the reported runs is best among those that suit; null if there is none.
const nlohmann::json* best_point(const nlohmann::json& trade, const std::function<bool(const nlohmann::json&)>& suits,
                                 const std::function<double(const nlohmann::json&)>& badness) {
  const nlohmann::json* best = nullptr;
  for (const auto& point : trade.at("points")) {
    const double bad = badness(point.at("reported"));
    if (suits(point) && std::isfinite(bad) && (best == nullptr || bad < badness(best->at("reported")))) best = &point;
  }
  return best;
}

/// The usual setting, the recommended one, and the ends of both fronts: a row for each.
std::string ends_of_fronts(const nlohmann::json& trade) {
  const auto value = [](const nlohmann::json& figure) { return number_or_nan(figure.at("value")); };
  const auto on_front = [](const char* which) {
    return [which](const nlohmann::json& point) { return point.at("front").at(which).get<bool>(); };
  };
  const auto is_recommended = [&](const nlohmann::json& point) { return point.at("id") == trade.at("recommendation").at("id"); };
  const std::vector<std::pair<std::string, const nlohmann::json*>> chosen{
      {"usual", &trade.at("points").front()},
      {"recommended", best_point(trade, is_recommended, [](const auto&) { return 0.0; })},
      {"most accurate",
       best_point(trade, on_front("accuracy"), [&](const auto& reported) { return -value(reported.at("accuracy")); })},
      {"fastest",
       best_point(trade, on_front("accuracy"), [&](const auto& reported) { return value(reported.at("us").at("p99")); })},
      {"fewest alarms",
       best_point(trade, on_front("delay"), [&](const auto& reported) { return value(reported.at("episodes_per_min")); })}};
  std::vector<std::vector<std::string>> rows;
  for (const auto& [name, point] : chosen) {
    if (point == nullptr) continue;
    const nlohmann::json& reported = point->at("reported");
    constexpr std::size_t widest = 26;
    rows.push_back({name, pictures::shortened(point->at("text").get<std::string>(), widest),
                    text_of(100 * value(reported.at("accuracy")), 1),
                    text_of(1e-3 * value(reported.at("delay_us").at("median")), 1),
                    text_of(value(reported.at("episodes_per_min")), 1), text_of(value(reported.at("us").at("p99")), 0)});
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
  const nlohmann::json& trade = summary.trade;
  std::string text = wrapped(trade.at("title").get<std::string>()) + "\n\n" + ends_of_fronts(trade) + "\n" +
                     wrapped(first_sentence(trade.at("recommendation").at("sentence").get<std::string>())) + "\n";
  if (const auto& unfinished = trade.at("unfinished"); !unfinished.is_null())
    text += wrapped(first_sentence(unfinished.get<std::string>())) + "\n";
  return text + fmt::format("{} settings; {} steps done, {} kept; --verbose prints all. Written to {}\n",
                            trade.at("points").size(), summary.done, summary.kept, summary.file.string());
}

std::string full_trade_text(const trade::TradeSummary& summary) {
  const nlohmann::json& trade = summary.trade;
  std::string text =
      trade.at("title").get<std::string>() + "\n\n" + wrapped(trade.at("times_are").get<std::string>()) + "\n\n" +
      wrapped(trade.at("judged_by").get<std::string>()) + "\n\n" +
      wrapped(
          "Of each setting: accuracy with its 95 % interval, median and 90 % quantile of the delay of presses and slips [ms] (a "
          "missed one counts with the time in which it could be detected), share missed or early [%], false alarms per minute "
          "outside labels, time per tick [us]. A: probability of being on the front of accuracy and time, with trainings, "
          "objects and runs drawn again; a star: on the front. D: the same for delay, misses and false alarms. Fronts are found "
          "on the runs to choose on. All other figures are of the runs to report on.") +
      "\n\n" + settings_text(trade) + growth_text(trade);
  if (const std::size_t pairs = trade.at("left_out").size(); pairs > 0) {
    std::string list;
    for (const auto& pair : trade.at("left_out"))
      list +=
          fmt::format("{}{:g}/{:g}", list.empty() ? "" : ", ", pair.at("th_ms").get<double>(), pair.at("tick_ms").get<double>());
    text +=
        wrapped(fmt::format("Left out, because the history is not a whole number of ticks (t_h/tick in ms): {}.", list)) + "\n";
  }
  for (const auto& one : trade.at("not_measured"))
    text +=
        wrapped(fmt::format("Not measured: {}: {}.", one.at("setting").get<std::string>(), one.at("why").get<std::string>())) +
        "\n";
  if (const auto& unfinished = trade.at("unfinished"); !unfinished.is_null())
    text += "\n" + wrapped(unfinished.get<std::string>()) + "\n";
  text += "\n" + wrapped(trade.at("usual_is").get<std::string>()) + "\n";
  text += "\n" + wrapped(trade.at("recommendation").at("sentence").get<std::string>()) + "\n\n";
  text += fmt::format("{} steps done, {} kept. Written to {}\n", summary.done, summary.kept, summary.file.string());
  return text;
}

}  // namespace tactile::cli
