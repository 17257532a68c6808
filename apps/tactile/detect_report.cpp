#include "detect_report.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "quantity_text.hpp"
#include "record_runs.hpp"
#include "text_table.hpp"

namespace tactile {
namespace {

double seconds_of(microseconds us) { return 1e-6 * static_cast<double>(us.count()); }

struct NamedHistogram {
  const char *key, *words;
  const DurationHistogram* histogram;
};

std::vector<NamedHistogram> histograms_of(const DeadlineMonitor& monitor) {
  return {{"waiting", "waiting for data", &monitor.waiting()},
          {"queued", "waiting for us", &monitor.queued()},
          {"rendering", "rendering", &monitor.rendering()},
          {"network", "network", &monitor.network()},
          {"output", "output", &monitor.output()},
          {"work", "rendering, network, output", &monitor.work()},
          {"answer", "from closed to told", &monitor.answer()},
          {"whole", "from the tick's end", &monitor.whole()}};
}

std::string latency_text(const DetectSummary& summary) {
  std::vector<std::vector<std::string>> rows;
  const auto us = [](std::chrono::nanoseconds ns) { return fmt::format("{:.0f}", 1e-3 * static_cast<double>(ns.count())); };
  const auto add = [&](const char* words, const DurationHistogram& histogram) {
    if (histogram.count() == 0) return;
    rows.push_back({words, us(histogram.percentile(0.5)), us(histogram.percentile(0.99)), us(histogram.percentile(0.999)),
                    us(histogram.max())});
  };
  for (const NamedHistogram& named : histograms_of(summary.deadlines)) add(named.words, *named.histogram);
  if (summary.robot) add("last event to register", summary.robot->from_event);
  if (rows.empty()) return {};
  std::string text = "\n" + text_table({"time of a tick [us]", "p50", "p99", "p99.9", "max"}, rows);
  const bool answers = summary.deadlines.answer().count() > 0;
  const DurationHistogram& shown = answers ? summary.deadlines.answer() : summary.deadlines.work();
  std::uint64_t most = 1;
  for (const DurationHistogram::Bin& bin : shown.octaves()) most = std::max(most, bin.count);
  std::vector<std::vector<std::string>> bars;
  for (const DurationHistogram::Bin& bin : shown.octaves()) {
    const auto length = static_cast<std::size_t>((40 * bin.count + most - 1) / most);
    bars.push_back({fmt::format("to {:.4g}", bin.to_us), std::to_string(bin.count), std::string(length, '#')});
  }
  return text + "\n" + text_table({answers ? "from closed to told [us]" : "work [us]", "ticks", ""}, bars);
}

}  // namespace

std::string text_of(const DetectSummary& summary) {
  const DeadlineMonitor::Counts& ticks = summary.deadlines.counts();
  std::vector<std::pair<std::string, std::string>> lines;
  lines.emplace_back("ticks", summary.plays
                                  ? fmt::format("{} told, none skipped; no deadline, since what is played waits", ticks.told)
                                  : fmt::format("{} told, {} skipped, {} more than a tick late: {:.3f} % missed", ticks.told,
                                                ticks.skipped, ticks.late, 100 * ticks.missed_share()));
  std::string said;
  for (const Touch touch : all_touches) {
    const auto index = static_cast<std::size_t>(touch);
    said += fmt::format("{}{} {}", said.empty() ? "" : ", ", name_of(touch), summary.verdicts[index]);
    if (touch != Touch::none) said += fmt::format(" in {}", counted(summary.episodes[index], "episode"));
  }
  lines.emplace_back("verdicts", said);
  if (summary.gate) {
    lines.emplace_back("gate",
                       fmt::format("{} of {} ticks with fewer than {} events", summary.counts.gated, ticks.told, *summary.gate));
  }
  if (!summary.plays)
    lines.emplace_back("closed", fmt::format("{} by events, {} by the host's time", ticks.told - summary.counts.by_host,
                                             summary.counts.by_host));
  std::string events = fmt::format("{} in {}", summary.counts.events, counted(summary.counts.packets, "packet"));
  if (summary.counts.late_events > 0) events += fmt::format(", {} too late", summary.counts.late_events);
  if (summary.counts.lost_events > 0)
    events += fmt::format(", {} dropped ({} incomplete)", summary.counts.lost_events, counted(summary.counts.incomplete, "tick"));
  lines.emplace_back("events", events);
  const LostElements unsound = summary.drops.total();
  if (unsound.packets + unsound.events > 0)
    lines.emplace_back("unsound", fmt::format("{}, {}", counted(unsound.packets, "packet"), counted(unsound.events, "event")));
  if (!summary.plays) lines.emplace_back("packets", fmt::format("{} at the longest", duration_text(summary.longest_packet)));
  std::string faults;
  for (const auto& [kind, count] : summary.faults) faults += fmt::format("{}{} {}", faults.empty() ? "" : ", ", count, kind);
  lines.emplace_back("faults", faults.empty() ? "none" : faults);
  if (summary.robot) {
    lines.emplace_back(
        "robot", fmt::format("{}, {} of bits, {}", counted(summary.robot->state.writes, "write"),
                             counted(summary.robot->raised, "rise"), counted(summary.robot->state.reconnects, "reconnect")));
  }
  if (summary.udp) lines.emplace_back("udp", fmt::format("{} sent, {} failed", (*summary.udp)[0], (*summary.udp)[1]));
  if (summary.counts.rehearsals > 0) lines.emplace_back("rehearsed", counted(summary.counts.rehearsals, "time"));
  const double elapsed = seconds_of(summary.elapsed);
  lines.emplace_back("lasted", fmt::format("{}, {:.1f} % of one core", duration_text(summary.elapsed),
                                           elapsed > 0 ? 100 * summary.cpu_s / elapsed : 0));
  if (summary.asked_for_real_time)
    lines.emplace_back("real time",
                       summary.real_time.empty() ? "ahead of other threads, memory locked" : summary.real_time.front());
  for (std::size_t i = 1; i < summary.real_time.size(); ++i) lines.emplace_back("", summary.real_time[i]);
  if (summary.may_sleep) lines.emplace_back("awake", summary.may_sleep->empty() ? "processors do not sleep" : *summary.may_sleep);
  lines.emplace_back("engine", summary.engine + ", " + summary.precision);
  lines.emplace_back("ended", summary.ended);
  std::string text = fmt::format("{}{} as {} sees it\n", summary.source, summary.simulated ? " (simulated)" : "", summary.model) +
                     text_list(lines) + latency_text(summary);
  if (summary.ticks_left_out > 0)
    text += fmt::format("\n{} are missing in what was written of them: it could not be written fast enough\n",
                        counted(summary.ticks_left_out, "tick"));
  if (summary.recorded) text += "\n" + text_of(*summary.recorded);
  return text;
}

nlohmann::json json_of(const DetectSummary& summary) {
  const DeadlineMonitor::Counts& ticks = summary.deadlines.counts();
  const auto us_or_null = [](const std::optional<CameraTime>& t) { return t ? nlohmann::json(us_of(*t)) : nlohmann::json(); };
  const LostElements unsound = summary.drops.total();
  nlohmann::json json = {
      {"model", summary.model},
      {"engine", summary.engine},
      {"precision", summary.precision},
      {"source", summary.source},
      {"simulated", summary.simulated},
      {"rendering", summary.rendering},
      {"confirm", text_of(summary.confirmation)},
      {"gate",
       summary.gate ? nlohmann::json{{"limit_events", *summary.gate}, {"gated", summary.counts.gated}} : nlohmann::json()},
      {"ended", summary.ended},
      {"elapsed_s", seconds_of(summary.elapsed)},
      {"cpu_s", summary.cpu_s},
      {"ticks",
       {{"told", ticks.told},
        {"skipped", ticks.skipped},
        {"late", summary.plays ? nlohmann::json() : nlohmann::json(ticks.late)},
        {"missed_share", summary.plays ? nlohmann::json() : nlohmann::json(ticks.missed_share())},
        {"by_events", ticks.told - summary.counts.by_host},
        {"by_host", summary.counts.by_host},
        {"incomplete", summary.counts.incomplete},
        {"rehearsals", summary.counts.rehearsals},
        {"first_us", us_or_null(summary.first_tick)},
        {"last_us", us_or_null(summary.last_tick)}}},
      {"events",
       {{"counted", summary.counts.events},
        {"late", summary.counts.late_events},
        {"dropped", summary.counts.lost_events},
        {"packets", summary.counts.packets},
        {"longest_packet_us", summary.longest_packet.count()},
        {"unsound_packets", unsound.packets},
        {"unsound_events", unsound.events}}},
      {"beginnings", summary.counts.beginnings},
      {"reopened", summary.reopened},
      {"verdicts", nlohmann::json::object()},
      {"episodes", {{"press", summary.episodes[1]}, {"slip", summary.episodes[2]}, {"first", nlohmann::json::array()}}},
      {"faults", {{"kinds", summary.faults}, {"first", nlohmann::json::array()}}},
      {"real_time", nullptr},
      {"awake", nullptr},
      {"robot", nullptr},
      {"udp", nullptr},
      {"recorded", nullptr},
      {"ticks_left_out", summary.ticks_left_out}};
  for (const Touch touch : all_touches)
    json["verdicts"][std::string(name_of(touch))] = summary.verdicts[static_cast<std::size_t>(touch)];
  for (const ToldEpisode& episode : summary.first_episodes)
    json["episodes"]["first"].push_back(
        {{"class", name_of(episode.touch)}, {"first_us", us_of(episode.first)}, {"last_us", us_of(episode.last)}});
  for (const DetectionFault& fault : summary.first_faults)
    json["faults"]["first"].push_back({{"kind", fault.kind}, {"text", fault.text}, {"host_time_us", us_of(fault.at)}});
  for (const NamedHistogram& named : histograms_of(summary.deadlines)) {
    json["latency_us"][named.key] = *named.histogram;
    nlohmann::json bins = nlohmann::json::array();
    for (const DurationHistogram::Bin& bin : named.histogram->octaves()) bins.push_back({bin.from_us, bin.to_us, bin.count});
    json["histogram_us"][named.key] = bins;
  }
  if (summary.asked_for_real_time) json["real_time"] = {{"granted", summary.real_time.empty()}, {"refused", summary.real_time}};
  if (summary.may_sleep) json["awake"] = {{"granted", summary.may_sleep->empty()}, {"refused", *summary.may_sleep}};
  if (summary.robot) {
    json["robot"] = {{"controller", summary.robot->state.controller},
                     {"writes", summary.robot->state.writes},
                     {"reconnects", summary.robot->state.reconnects},
                     {"raised", summary.robot->raised},
                     {"event_to_write_us", summary.robot->from_event}};
  }
  if (summary.udp) json["udp"] = {{"sent", (*summary.udp)[0]}, {"failed", (*summary.udp)[1]}};
  if (summary.recorded) json["recorded"] = json_of(*summary.recorded);
  return json;
}

}  // namespace tactile
