#include "tactile/splitting/split_proposal.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/events/cut_recording.hpp"
#include "tactile/splitting/joined_bursts.hpp"
#include "tactile/splitting/run_groups.hpp"

namespace tactile::splitting {
namespace {

using alignment::Burst;
using alignment::EventRate;
using Bursts = std::vector<Burst>;

double seconds_between(CameraTime from, CameraTime to) { return 1e-6 * static_cast<double>(between(from, to).count()); }

/// The first and the last event, by the list of packets.
struct Extent {
  CameraTime first = CameraTime::max(), last = CameraTime::min();
};

Extent extent_of(const events::RecordingReader& recording, std::int32_t stream) {
  Extent extent;
  for (const events::PacketRecord& packet : recording.packets()) {
    if (packet.stream_id != stream || packet.elements <= 0) continue;
    extent.first = std::min(extent.first, packet.first);
    extent.last = std::max(extent.last, packet.last);
  }
  if (extent.first > extent.last)
    throw Error(recording.file().string() + ": holds no event; expected a recording of several runs");
  return extent;
}

/// The middle of the longest stretch of [begin, end) without a brief burst.
std::size_t middle_of_quiet(std::size_t begin, std::size_t end, const Bursts& brief) {
  std::size_t best_begin = begin, best_end = begin, from = begin;
  const auto look_until = [&](std::size_t until) {
    if (until > from && until - from > best_end - best_begin) std::tie(best_begin, best_end) = std::pair(from, until);
  };
  for (const Burst& burst : brief) {
    if (burst.end <= begin || burst.begin >= end) continue;
    look_until(burst.begin);
    from = std::max(from, burst.end);
  }
  look_until(end);
  return best_begin + (best_end - best_begin) / 2;
}

void check_cuts(const SplitProposal& proposal, const std::string& where, const std::vector<CameraTime>& cuts) {
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    const double at = seconds_between(proposal.first, cuts[i]);
    if (i > 0 && cuts[i] <= cuts[i - 1])
      throw Error(fmt::format("{}: the cut at {:.6f} s is not after the one at {:.6f} s; expected ascending times", where, at,
                              seconds_between(proposal.first, cuts[i - 1])));
    if (cuts[i] <= proposal.first || cuts[i] > proposal.last)
      throw Error(fmt::format("{}: the cut at {:.6f} s is outside the recording; expected more than 0, at most {:.6f} s", where,
                              at, seconds_between(proposal.first, proposal.last)));
  }
}

EventRate rate_of(events::RecordingReader& recording, std::int32_t stream, const ProposeOptions& options) {
  const Extent extent = extent_of(recording, stream);
  alignment::EventRateOptions rate_options;
  rate_options.hot_pixel_hz = 50.0;  // pixels at a marker fire in every run, so only those that fire much faster are hot
  rate_options.longest = std::chrono::hours(48);
  const auto most_bins = static_cast<std::int64_t>(options.most_bins);
  rate_options.bin = std::max(rate_options.bin, microseconds{between(extent.first, extent.last).count() / most_bins});
  return alignment::event_rate(recording, stream, rate_options);
}

void find_clocks(SplitProposal& proposal, const SplitSource& source, events::RecordingReader& recording, const EventRate& rate,
                 const alignment::QuietRate& quiet) {
  if (source.robot) proposal.robot = find_robot_clock(source, recording, proposal.event_stream, rate, quiet);
  if (source.video) proposal.film = find_film_clock(source);
}

}  // namespace

SplitProposal propose_runs(const SplitSource& source, events::RecordingReader& recording, const ProposeOptions& options,
                           const ProgressCallback& progress) {
  const std::string name = recording.file().filename().string();
  SplitProposal proposal;
  proposal.event_stream = events::event_stream(recording, options.stream).id;
  proposal.quiet_needed = options.quiet;
  report_progress(progress, 0, 4, name + ": event rate");
  const EventRate rate = rate_of(recording, proposal.event_stream, options);
  LongActivity activity = activity_in(rate, options.activity);
  proposal.first = rate.begin;
  proposal.last = rate.last;
  if (activity.has_quiet) proposal.quiet_per_s = activity.quiet.mean * 1e6 / static_cast<double>(rate.bin.count());
  proposal.looked_for_touches = true;

  report_progress(progress, 1, 4, name + ": clocks");
  find_clocks(proposal, source, recording, rate, activity.quiet);
  report_progress(progress, 2, 4, name + ": slow touches");
  const Bursts all = joined_and_slow_bursts(recording, proposal.event_stream, rate, activity.quiet, std::move(activity.bursts),
                                            proposal.robot.lifts.value_or(std::vector<ArmMove>()), activity.pauses);

  const auto quiet_bins = static_cast<std::size_t>(std::max<std::int64_t>(1, options.quiet / rate.bin));
  report_progress(progress, 3, 4, name + ": touches");
  const RunGroups groups = grouped_runs(recording, proposal.event_stream, rate, all, activity, quiet_bins, proposal.robot);
  std::vector<CameraTime> cuts;
  for (std::size_t i = 0; i < groups.runs.size(); ++i) {
    const RunGroup& run = groups.runs[i];
    for (std::size_t k = 0; k < run.bursts.size(); ++k)
      proposal.touches.push_back(
          {.begin = rate.begin_of(run.bursts[k].begin), .end = rate.begin_of(run.bursts[k].end), .kind = run.kinds[k]});
    if (i == 0) continue;
    const std::size_t quiet_from = groups.runs[i - 1].bursts.back().end;
    cuts.push_back(rate.begin_of(middle_of_quiet(quiet_from, run.bursts.front().begin, groups.brief)));
  }
  return with_cuts(std::move(proposal), recording, std::move(cuts));
}

SplitProposal proposal_with(const SplitSource& source, events::RecordingReader& recording,
                            const std::vector<microseconds>& after_first, const ProposeOptions& options) {
  SplitProposal proposal;
  proposal.event_stream = events::event_stream(recording, options.stream).id;
  const Extent extent = extent_of(recording, proposal.event_stream);
  proposal.first = extent.first;
  proposal.last = extent.last;
  std::vector<CameraTime> cuts(after_first.size());
  std::transform(after_first.begin(), after_first.end(), cuts.begin(), [&](microseconds t) { return after(extent.first, t); });
  proposal = with_cuts(std::move(proposal), recording, std::move(cuts));
  if (!source.robot && !source.video) return proposal;
  const EventRate rate = source.robot ? rate_of(recording, proposal.event_stream, options) : EventRate{};
  find_clocks(proposal, source, recording, rate, activity_in(rate, options.activity).quiet);
  return proposal;
}

SplitProposal with_cuts(SplitProposal proposal, events::RecordingReader& recording, std::vector<CameraTime> cuts) {
  const std::string where = recording.file().string();
  check_cuts(proposal, where, cuts);
  proposal.cuts = std::move(cuts);
  proposal.events = events::events_of_pieces(recording, proposal.event_stream, proposal.cuts);
  for (const ProposedRun& run : runs_of(proposal)) {
    if (run.events > 0) continue;
    throw Error(fmt::format("{}: has no event from {:.6f} to {:.6f} s; expected cuts with events between them", where,
                            seconds_between(proposal.first, run.begin), seconds_between(proposal.first, run.end)));
  }
  return proposal;
}

std::vector<ProposedRun> runs_of(const SplitProposal& proposal) {
  std::vector<ProposedRun> runs(proposal.cuts.size() + 1);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    runs[i].begin = i == 0 ? proposal.first : proposal.cuts[i - 1];
    runs[i].end = i < proposal.cuts.size() ? proposal.cuts[i] : after(proposal.last, 1us);
    runs[i].events = i < proposal.events.size() ? proposal.events[i] : 0;
  }
  const SeenTouch* previous = nullptr;
  for (const SeenTouch& touch : proposal.touches) {
    ProposedRun& run = runs[events::piece_of(proposal.cuts, touch.begin)];
    if (run.touches.empty() && previous != nullptr) run.quiet_before = between(previous->end, touch.begin);
    run.touches.push_back(touch);
    if (previous == nullptr || touch.end > previous->end) previous = &touch;
  }
  return runs;
}

std::optional<microseconds> longest_quiet_within(const SplitProposal& proposal) {
  std::optional<microseconds> longest;
  for (const ProposedRun& run : runs_of(proposal)) {
    for (std::size_t i = 1; i < run.touches.size(); ++i)
      longest = std::max(longest.value_or(0us), between(run.touches[i - 1].end, run.touches[i].begin));
  }
  return longest;
}

std::size_t count_of(const ProposedRun& run, BurstKind kind) {
  return static_cast<std::size_t>(
      std::count_if(run.touches.begin(), run.touches.end(), [&](const SeenTouch& touch) { return touch.kind == kind; }));
}

std::string_view name_of(BurstKind kind) {
  constexpr std::array<std::string_view, 6> names{"press", "slip", "release", "tap", "brief", "after"};
  return names.at(static_cast<std::size_t>(kind));
}

nlohmann::json json_of(const SplitProposal& proposal) {
  nlohmann::json runs = nlohmann::json::array();
  for (const ProposedRun& run : runs_of(proposal)) {
    nlohmann::json touches = nlohmann::json::array();
    for (const SeenTouch& touch : run.touches)
      touches.push_back({{"kind", name_of(touch.kind)}, {"begin_us", us_of(touch.begin)}, {"end_us", us_of(touch.end)}});
    nlohmann::json json = {{"begin_us", us_of(run.begin)},
                           {"end_us", us_of(run.end)},
                           {"begin_s", seconds_between(proposal.first, run.begin)},
                           {"end_s", seconds_between(proposal.first, run.end)},
                           {"events", run.events}};
    json["quiet_before_s"] =
        run.quiet_before ? nlohmann::json(1e-6 * static_cast<double>(run.quiet_before->count())) : nlohmann::json();
    json["presses"] = proposal.looked_for_touches ? nlohmann::json(count_of(run, BurstKind::press)) : nlohmann::json();
    json["slips"] = proposal.looked_for_touches ? nlohmann::json(count_of(run, BurstKind::slip)) : nlohmann::json();
    json["touches"] = proposal.looked_for_touches ? touches : nlohmann::json();
    runs.push_back(std::move(json));
  }
  nlohmann::json cuts = nlohmann::json::array();
  for (const CameraTime cut : proposal.cuts) cuts.push_back(us_of(cut));
  const std::optional<microseconds> within = longest_quiet_within(proposal);
  return {{"first_us", us_of(proposal.first)},
          {"last_us", us_of(proposal.last)},
          {"quiet_s", proposal.looked_for_touches ? nlohmann::json(1e-6 * static_cast<double>(proposal.quiet_needed.count()))
                                                  : nlohmann::json()},
          {"quiet_events_per_s", proposal.quiet_per_s ? nlohmann::json(*proposal.quiet_per_s) : nlohmann::json()},
          {"longest_quiet_within_s", within ? nlohmann::json(1e-6 * static_cast<double>(within->count())) : nlohmann::json()},
          {"cuts_us", cuts},
          {"runs", runs}};
}

}  // namespace tactile::splitting
