#include "tactile/experiments/trade/time_points.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/machine.hpp"
#include "tactile/core/version.hpp"
#include "tactile/evaluation/run_result.hpp"
#include "tactile/experiments/file_step.hpp"

namespace tactile::trade {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

json json_of(const TimedSetting& setting) {
  return {{"rendering", setting.rendering},
          {"engine", name_of(setting.engine)},
          {"precision", name_of(setting.precision)},
          {"weights", model::read_description({setting.model}).weights_sha256}};
}

/// The settings of the points that cost different time.
std::vector<TimedSetting> timed_settings_of(std::span<const TradePoint> points) {
  std::vector<TimedSetting> settings;
  for (const TradePoint& point : points) {
    const TimedSetting setting = timed_setting_of(point);
    if (std::find(settings.begin(), settings.end(), setting) == settings.end()) settings.push_back(setting);
  }
  return settings;
}

fs::path times_file(const TradePlan& plan, const std::string& step_name) {
  return plan.options.out / "times" / (step_name + ".ticks");
}

experiments::Step step_to_time(const TradePlan& plan, const std::vector<TimedSetting>& settings, const std::string& name,
                               const TickTimesOptions& timing) {
  json timed = json::array();
  for (const TimedSetting& setting : settings) timed.push_back(json_of(setting));
  const std::vector<std::uint32_t> tested = plan.tested();
  std::vector<fs::path> recordings;
  for (const RunFolder& run : plan.folders(tested)) recordings.push_back(run.events());
  const fs::path file = times_file(plan, name);
  return experiments::file_step(
      name,
      {{"manifest", plan.dataset.manifest_hash()},
       {"runs", plan.names(tested)},
       {"events", plan.hashes(tested)},
       {"ways", timed},
       {"machine", cpu_name()},
       {"revision", revision()},
       {"pieces", timing.pieces},
       {"ticks", timing.ticks},
       {"turns", timing.turns}},
      file, [=](const ProgressCallback& progress) { write_times(file, time_ticks(settings, recordings, timing, progress)); },
      fmt::format("timing {} ticks of each of {} settings, in turns, in {} runs", timing.ticks, settings.size(), tested.size()));
}

double likeliness(const TradePoint& point) {
  return point.front_probability.accuracy.value_or(0) + point.front_probability.delay.value_or(0) +
         (point.on_accuracy_front || point.on_delay_front ? 1 : 0);
}

/// The ids of the points with the `most` settings to time: of the usual one, then of those that are likeliest on a front.
std::vector<std::string> likeliest(std::vector<TradePoint> points, std::size_t most) {
  std::stable_sort(points.begin() + 1, points.end(),
                   [](const TradePoint& a, const TradePoint& b) { return likeliness(a) > likeliness(b); });
  std::vector<std::string> ids;
  std::vector<TimedSetting> timed;
  for (const TradePoint& point : points) {
    const TimedSetting setting = timed_setting_of(point);
    const bool shares = std::find(timed.begin(), timed.end(), setting) != timed.end();
    if (!shares && timed.size() >= most) continue;
    if (!shares) timed.push_back(setting);
    ids.push_back(id_of(point.setting));
  }
  return ids;
}

void keep_what_can_be_timed(const Stage& stage, std::uint64_t ticks, MeasuredPoints& measured) {
  const double each_s = timing_s(stage, ticks, measured.times);
  if (stage.budget.allows(each_s * static_cast<double>(timed_settings_of(measured.points).size()))) return;
  const auto most = static_cast<std::size_t>(std::max(0.0, stage.budget.left_s() / each_s));
  const std::vector<std::string> kept = likeliest(measured.points, most);
  remove_unless(
      measured, stage.plan.options.usual,
      [&](const TradePoint& point) { return std::find(kept.begin(), kept.end(), id_of(point.setting)) != kept.end(); },
      budget_words(stage.plan, "its ticks were timed"));
  expect_usual(stage, measured, "the ticks of the usual setting are not timed yet");
}

}  // namespace

double timing_s(const Stage& stage, std::uint64_t ticks, const PointTimes& known) {
  constexpr double margin = 1.5;  // on a busy machine
  std::uint64_t timed = 0;
  for (const TimesOfRuns& of_setting : known.times) {
    for (const auto& run : of_setting) timed += run.size();
  }
  const double seconds = longest_s(stage.runner, "times");
  const double us = timed > 0 && seconds > 0 ? 1e6 * seconds / static_cast<double>(timed) : usual_tick_us;
  return 1e-6 * margin * us * static_cast<double>(ticks);
}

void time_points(const Stage& stage, const std::string& step_name, std::uint64_t ticks, MeasuredPoints& measured) {
  TickTimesOptions timing = stage.plan.options.timing;
  // With fewer ticks in fewer pieces: each piece costs a whole history, and its time must not count as that of one or two ticks.
  const auto pieces = (timing.pieces * ticks + timing.ticks - 1) / timing.ticks;
  timing.pieces = static_cast<unsigned>(std::clamp<std::uint64_t>(pieces, 1, timing.pieces));
  timing.ticks = ticks;
  const auto step = [&] { return step_to_time(stage.plan, timed_settings_of(measured.points), step_name, timing); };
  if (!stage.runner.is_done(step())) keep_what_can_be_timed(stage, ticks, measured);
  if (!stage.budget.finishes([&] { stage.runner.run(step()); }))
    throw Error("the budget ended while ticks were timed; expected more time. " + stage.trainer.unfinished());
  const fs::path file = times_file(stage.plan, step_name);
  measured.times = {.settings = timed_settings_of(measured.points), .times = read_times(file)};
  if (measured.times.times.size() != measured.times.settings.size())
    throw Error(file.string() + ": times of other settings; expected those measured");
}

}  // namespace tactile::trade
