#include "detect_page.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "tactile/core/duration_units.hpp"
#include "tactile/core/robust_statistics.hpp"

namespace tactile::cli {
namespace {

using Steady = std::chrono::steady_clock;

constexpr std::size_t most_messages = 5;

}  // namespace

void DetectPage::warn(const std::string& text) {
  const std::scoped_lock lock(guard_);
  messages_.push_back(text);
  if (messages_.size() > most_messages) messages_.pop_front();
}

std::string DetectPage::open(events::SensorSize sensor, const heatmaps::HeatmapOptions& rendering) {
  tick_ = rendering.tick;
  return view_.open({.sensor = sensor, .rendering = rendering, .values = {"p_press", "p_slip", "lateness_ms"}});
}

detect::TickOutput DetectPage::shown(detect::TickOutput output) {
  output.ticks = [this, next = std::move(output.ticks)](std::span<const detect::ReportedTick> ticks) {
    next(ticks);
    take(ticks);
  };
  return output;
}

void DetectPage::take(std::span<const detect::ReportedTick> ticks) {
  const Steady::time_point now = Steady::now();
  const double none = std::numeric_limits<double>::quiet_NaN();
  std::array<double, 3> highest{none, none, none};
  for (const detect::ReportedTick& tick : ticks) {
    ++ticks_;
    skipped_ += tick.due.skipped;
    incomplete_ += tick.incomplete ? 1 : 0;
    const model::Probabilities& p = tick.verdict.probabilities;
    highest[0] = std::fmax(highest[0], static_cast<double>(p[1]));
    highest[1] = std::fmax(highest[1], static_cast<double>(p[2]));
    if (!tick.lateness) continue;
    late_ += *tick.lateness > tick_ ? 1 : 0;
    const double ms = in_ms(*tick.lateness);
    highest[2] = std::fmax(highest[2], ms);
    lateness_.push_back({now, ms});
  }
  while (!lateness_.empty() && now - lateness_.front().at > std::chrono::seconds(1)) lateness_.pop_front();
  if (!ticks.empty()) {
    newest_ = ticks.back();
    view_.note(highest);
  }
  if (view_.is_due()) view_.publish(state_json("detecting"));
}

/// Of the last second; null without ticks that have a deadline.
nlohmann::json DetectPage::lateness_json() const {
  if (lateness_.empty()) return nullptr;
  std::vector<double> ms;
  for (const Lateness& one : lateness_) ms.push_back(one.ms);
  return {{"p50_ms", nearest_rank_quantile(ms, 0.5)},
          {"p99_ms", nearest_rank_quantile(ms, 0.99)},
          {"max_ms", nearest_rank_quantile(ms, 1)}};
}

/// Once a second: a disk of another machine may take its time.
void DetectPage::look_at_disk() {
  const Steady::time_point now = Steady::now();
  if (labels_.recorded.empty() || now - disk_seen_ < std::chrono::seconds(1)) return;
  disk_seen_ = now;
  disk_warnings_.clear();
  disk_ = disk_json(labels_.recorded, std::nullopt, disk_warnings_);
}

nlohmann::json DetectPage::state_json(const char* state) {
  look_at_disk();
  nlohmann::json json = {{"kind", "detect"},
                         {"state", state},
                         {"source", labels_.source},
                         {"model", labels_.model},
                         {"tick", nullptr},
                         {"ticks", {{"reported", ticks_}, {"skipped", skipped_}, {"late", late_}, {"incomplete", incomplete_}}},
                         {"lateness", lateness_json()},
                         {"disk", disk_},
                         {"warnings", disk_warnings_}};
  if (newest_) {
    const detect::TickVerdict& verdict = newest_->verdict;
    const model::Probabilities& p = verdict.probabilities;
    json["tick"] = {{"t_us", us_of(verdict.t)},
                    {"verdict", name_of(verdict.verdict)},
                    {"predicted", name_of(verdict.predicted)},
                    {"slip_is_confirmed", verdict.slip_is_confirmed},
                    {"p", {p[0], p[1], p[2]}},
                    {"events", verdict.events},
                    {"beginning", newest_->beginning}};
    json["events"] = {{"late", newest_->late_events}, {"dropped", newest_->lost_events}};
  }
  const std::scoped_lock lock(guard_);
  json["messages"] = messages_;
  return json;
}

void DetectPage::end(const detect::DetectionSummary& summary) {
  nlohmann::json state = state_json("ended");
  state["words"] = summary.ended;
  view_.end(std::move(state));
}

}  // namespace tactile::cli
