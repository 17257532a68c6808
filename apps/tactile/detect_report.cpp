#include "detect_report.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "quantity_text.hpp"
#include "record_runs.hpp"
#include "tactile/core/duration_units.hpp"
#include "text_table.hpp"

namespace tactile::cli {
namespace {

struct NamedHistogram {
  const char *key, *words;
  const detect::DurationHistogram* histogram;
};

std::vector<NamedHistogram> histograms_of(const detect::DeadlineMonitor& monitor) {
  return {{"waiting", "waiting for data", &monitor.waiting()},
          {"queued", "waiting for detect", &monitor.queued()},
          {"rendering", "rendering", &monitor.rendering()},
          {"network", "network", &monitor.network()},
          {"output", "output", &monitor.output()},
          {"work", "rendering, network, output", &monitor.work()},
          {"answer", "from closed to verdict", &monitor.answer()},
          {"whole", "from the tick's end", &monitor.whole()}};
}

std::string us(std::chrono::nanoseconds ns) { return fmt::format("{:.0f}", 1e-3 * static_cast<double>(ns.count())); }

std::string latency_text(const detect::DetectionSummary& summary) {
  std::vector<std::vector<std::string>> rows;
  const auto add = [&](const char* words, const detect::DurationHistogram& histogram) {
    if (histogram.count() == 0) return;
    rows.push_back({words, us(histogram.percentile(0.5)), us(histogram.percentile(0.99)), us(histogram.percentile(0.999)),
                    us(histogram.max())});
  };
  for (const NamedHistogram& named : histograms_of(summary.deadlines)) add(named.words, *named.histogram);
  if (summary.robot) add("last event to register", summary.robot->from_event);
  if (rows.empty()) return {};
  std::string text = "\n" + text_table({"time of a tick [us]", "p50", "p99", "p99.9", "max"}, rows);
  const bool answers = summary.deadlines.answer().count() > 0;
  const detect::DurationHistogram& shown = answers ? summary.deadlines.answer() : summary.deadlines.work();
  std::uint64_t most = 1;
  for (const detect::DurationHistogram::Bin& bin : shown.octaves()) most = std::max(most, bin.count);
  std::vector<std::vector<std::string>> bars;
  for (const detect::DurationHistogram::Bin& bin : shown.octaves()) {
    const auto length = static_cast<std::size_t>((40 * bin.count + most - 1) / most);
    bars.push_back({fmt::format("to {:.4g}", bin.to_us), std::to_string(bin.count), std::string(length, '#')});
  }
  return text + "\n" + text_table({answers ? "from closed to verdict [us]" : "work [us]", "ticks", ""}, bars);
}

double percentage(std::uint64_t part, std::uint64_t whole) {
  return whole > 0 ? 100 * static_cast<double>(part) / static_cast<double>(whole) : 0.0;
}

using Lines = std::vector<std::pair<std::string, std::string>>;

std::string verdicts_text(const detect::VerdictCounts& counts) {
  std::string text;
  for (const Touch touch : all_touches) {
    const auto index = static_cast<std::size_t>(touch);
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", name_of(touch), counts.ticks[index]);
    if (touch != Touch::none) text += fmt::format(" in {}", counted(counts.episodes[index], "episode"));
  }
  if (counts.episodes[static_cast<std::size_t>(Touch::slip)] > 0) text += fmt::format(", {} confirmed", counts.confirmed_slips);
  return text;
}

void add_ticks(const detect::DetectionSummary& summary, Lines& lines) {
  const detect::DeadlineMonitor::Counts& ticks = summary.deadlines.counts();
  lines.emplace_back("ticks", summary.plays ? fmt::format("{} reported, none skipped; no deadline for a replay", ticks.reported)
                                            : fmt::format("{} reported, {} skipped, {} more than a tick late: {:.3f} % missed",
                                                          ticks.reported, ticks.skipped, ticks.late, 100 * ticks.missed_share()));
  if (summary.counts.incomplete > 0)
    lines.emplace_back(
        "incomplete",
        fmt::format("{}, {:.3f} %: judged without all events of their history; not counted as missed",
                    counted(summary.counts.incomplete, "tick"), percentage(summary.counts.incomplete, ticks.reported)));
  lines.emplace_back("verdicts", verdicts_text(summary.verdicts));
  if (!summary.plays)
    lines.emplace_back(
        "closed", fmt::format("{} by events, {} by host time", ticks.reported - summary.counts.by_host, summary.counts.by_host));
}

/// What matters of a tick's time: all of it where verdicts have a deadline, else the work alone.
void add_latency(const detect::DetectionSummary& summary, Lines& lines) {
  const detect::DurationHistogram& time = summary.plays ? summary.deadlines.work() : summary.deadlines.whole();
  if (time.count() == 0) return;
  lines.emplace_back(
      summary.plays ? "work" : "latency",
      fmt::format("{} us (median), {} us (99 %), {} us (highest) {}", us(time.percentile(0.5)), us(time.percentile(0.99)),
                  us(time.max()), summary.plays ? "for rendering, network and output" : "from a tick's end to its verdict"));
}

void add_events(const detect::DetectionSummary& summary, Lines& lines) {
  const detect::LiveCounts& counts = summary.counts;
  std::string events = fmt::format("{} in {}", counts.events, counted(counts.packets, "packet"));
  const std::uint64_t arrived = counts.events + counts.late_events + counts.lost_events;
  if (counts.late_events > 0)
    events += fmt::format(", {} too late ({:.3f} %)", counts.late_events, percentage(counts.late_events, arrived));
  if (counts.lost_events > 0)
    events += fmt::format(", {} dropped ({:.3f} %)", counts.lost_events, percentage(counts.lost_events, arrived));
  lines.emplace_back("events", events);
  // A few late events are no reason to wait longer, unless many ticks lack them.
  const bool many_are_late = 100 * counts.late_events > arrived || 20 * counts.incomplete > summary.deadlines.counts().reported;
  if (many_are_late && summary.proposed_slack)
    lines.emplace_back("", fmt::format("with --slack-us {} most of them would be in time; ticks wait up to {:g} ms for them",
                                       summary.proposed_slack->count(), in_ms(*summary.proposed_slack)));
  const capture::LostElements unsound = summary.drops.total();
  if (unsound.packets + unsound.events > 0)
    lines.emplace_back("unsound", fmt::format("{}, {}", counted(unsound.packets, "packet"), counted(unsound.events, "event")));
  if (!summary.plays) lines.emplace_back("packets", fmt::format("{} at the longest", duration_text(summary.longest_packet)));
  std::string faults;
  for (const auto& [kind, count] : summary.faults)
    faults += fmt::format("{}{} {}", faults.empty() ? "" : ", ", kind, counted(count, "time"));
  lines.emplace_back("faults", faults.empty() ? "none" : faults);
}

void add_scene(const detect::DetectionSummary& summary, Lines& lines) {
  if (!summary.scene) return;
  const detect::SceneSummary& scene = *summary.scene;
  if (scene.windows == 0) {
    if (scene.skipped > 0) lines.emplace_back("scene", "not measured, because too many events were late or dropped");
    return;
  }
  const std::string seen = "in " + counted(scene.windows, "look");
  lines.emplace_back("scene", scene.left == 0
                                  ? "as in the training runs " + seen
                                  : fmt::format("left the training runs {} {}, {} at the end", counted(scene.left, "time"), seen,
                                                scene.is_outside ? "outside" : "inside"));
}

nlohmann::json scene_json(const std::optional<detect::SceneSummary>& scene) {
  if (!scene) return nullptr;
  return {{"training", scene->training},
          {"windows", scene->windows},
          {"skipped", scene->skipped},
          {"left", scene->left},
          {"returned", scene->returned},
          {"is_outside", scene->is_outside},
          {"last", scene->last ? characterise::json_of(*scene->last) : nlohmann::json()}};
}

void add_outputs(const detect::DetectionSummary& summary, Lines& lines) {
  if (summary.robot) {
    lines.emplace_back(
        "robot", fmt::format("{}, {} of bits, {}", counted(summary.robot->state.writes, "write"),
                             counted(summary.robot->raised, "rise"), counted(summary.robot->state.reconnects, "reconnect")));
  }
  if (summary.udp) lines.emplace_back("udp", fmt::format("{} sent, {} failed", (*summary.udp)[0], (*summary.udp)[1]));
}

void add_machine(const detect::DetectionSummary& summary, Lines& lines) {
  if (summary.counts.rehearsals > 0) lines.emplace_back("rehearsed", counted(summary.counts.rehearsals, "time"));
  const double elapsed = in_s(summary.elapsed);
  lines.emplace_back("lasted", fmt::format("{}, {:.1f} % of one core", duration_text(summary.elapsed),
                                           elapsed > 0 ? 100 * summary.cpu_s / elapsed : 0));
  if (summary.used_real_time) {
    const std::vector<std::string>& refused = summary.real_time_refused;
    lines.emplace_back("real time", refused.empty() ? "real-time priority, memory locked" : refused.front());
    for (std::size_t i = 1; i < refused.size(); ++i) lines.emplace_back("", refused[i]);
  }
  if (summary.awake_refused)
    lines.emplace_back("awake", summary.awake_refused->empty() ? "processor cores do not sleep" : *summary.awake_refused);
}

nlohmann::json us_or_null(const std::optional<CameraTime>& t) { return t ? nlohmann::json(us_of(*t)) : nlohmann::json(); }

nlohmann::json ticks_json(const detect::DetectionSummary& summary) {
  const detect::DeadlineMonitor::Counts& ticks = summary.deadlines.counts();
  return {{"reported", ticks.reported},
          {"skipped", ticks.skipped},
          {"late", summary.plays ? nlohmann::json() : nlohmann::json(ticks.late)},
          {"missed_share", summary.plays ? nlohmann::json() : nlohmann::json(ticks.missed_share())},
          {"by_events", ticks.reported - summary.counts.by_host},
          {"by_host", summary.counts.by_host},
          {"incomplete", summary.counts.incomplete},
          {"rehearsals", summary.counts.rehearsals},
          {"first_us", us_or_null(summary.verdicts.first_tick)},
          {"last_us", us_or_null(summary.verdicts.last_tick)}};
}

nlohmann::json events_json(const detect::DetectionSummary& summary) {
  const capture::LostElements unsound = summary.drops.total();
  return {{"counted", summary.counts.events},
          {"late", summary.counts.late_events},
          {"proposed_slack_us", summary.proposed_slack ? nlohmann::json(summary.proposed_slack->count()) : nlohmann::json()},
          {"dropped", summary.counts.lost_events},
          {"packets", summary.counts.packets},
          {"longest_packet_us", summary.longest_packet.count()},
          {"unsound_packets", unsound.packets},
          {"unsound_events", unsound.events}};
}

void add_verdicts(const detect::VerdictCounts& counts, nlohmann::json& json) {
  for (const Touch touch : all_touches)
    json["verdicts"][std::string(name_of(touch))] = counts.ticks[static_cast<std::size_t>(touch)];
  json["episodes"] = {{"press", counts.episodes[1]},
                      {"slip", counts.episodes[2]},
                      {"confirmed_slip", counts.confirmed_slips},
                      {"first", nlohmann::json::array()}};
  for (const detect::VerdictEpisode& episode : counts.first_episodes)
    json["episodes"]["first"].push_back({{"class", name_of(episode.touch)},
                                         {"first_us", us_of(episode.first)},
                                         {"confirmed_us", us_or_null(episode.confirmed)},
                                         {"last_us", us_of(episode.last)}});
}

void add_faults(const detect::DetectionSummary& summary, nlohmann::json& json) {
  json["faults"] = {{"kinds", summary.faults}, {"first", nlohmann::json::array()}};
  for (const detect::DetectionFault& fault : summary.first_faults)
    json["faults"]["first"].push_back({{"kind", fault.kind}, {"text", fault.text}, {"host_time_us", us_of(fault.at)}});
}

void add_latencies(const detect::DeadlineMonitor& deadlines, nlohmann::json& json) {
  for (const NamedHistogram& named : histograms_of(deadlines)) {
    json["latency_us"][named.key] = *named.histogram;
    nlohmann::json bins = nlohmann::json::array();
    for (const detect::DurationHistogram::Bin& bin : named.histogram->octaves())
      bins.push_back({bin.from_us, bin.to_us, bin.count});
    json["histogram_us"][named.key] = bins;
  }
}

}  // namespace

std::string text_of(const detect::DetectionSummary& summary, const DetectModel& model, bool all) {
  Lines lines;
  add_ticks(summary, lines);
  add_latency(summary, lines);
  add_events(summary, lines);
  add_scene(summary, lines);
  add_outputs(summary, lines);
  add_machine(summary, lines);
  lines.emplace_back("engine", model.engine + ", " + model.precision);
  lines.emplace_back("ended", summary.ended);
  std::string text = fmt::format("{}{}, predicted by {}\n", summary.source, summary.simulated ? " (simulated)" : "", model.name) +
                     text_list(lines) + (all ? latency_text(summary) : "");
  if (summary.ticks_left_out > 0)
    text += fmt::format("\n{} could not be written fast enough, and are missing in the files\n",
                        counted(summary.ticks_left_out, "tick"));
  if (summary.recorded) text += "\n" + text_of(*summary.recorded);
  return text;
}

nlohmann::json json_of(const detect::DetectionSummary& summary, const DetectModel& model) {
  const detect::TickDetectorOptions& detector = summary.detector;
  nlohmann::json json = {
      {"model", model.name},
      {"engine", model.engine},
      {"precision", model.precision},
      {"source", summary.source},
      {"simulated", summary.simulated},
      {"rendering", detector.rendering},
      {"confirm", text_of(detector.decision.confirmation)},
      {"thresholds", detector.decision.thresholds ? nlohmann::json(text_of(*detector.decision.thresholds)) : nlohmann::json()},
      {"ended", summary.ended},
      {"elapsed_s", in_s(summary.elapsed)},
      {"cpu_s", summary.cpu_s},
      {"ticks", ticks_json(summary)},
      {"events", events_json(summary)},
      {"beginnings", summary.counts.beginnings},
      {"reopened", summary.reopened},
      {"real_time", nullptr},
      {"awake", nullptr},
      {"robot", nullptr},
      {"udp", nullptr},
      {"recorded", nullptr},
      {"scene", scene_json(summary.scene)},
      {"ticks_left_out", summary.ticks_left_out}};
  add_verdicts(summary.verdicts, json);
  add_faults(summary, json);
  add_latencies(summary.deadlines, json);
  if (summary.used_real_time)
    json["real_time"] = {{"granted", summary.real_time_refused.empty()}, {"refused", summary.real_time_refused}};
  if (summary.awake_refused) json["awake"] = {{"granted", summary.awake_refused->empty()}, {"refused", *summary.awake_refused}};
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

}  // namespace tactile::cli
