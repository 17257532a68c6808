#include "tactile/splitting/split_proposal.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/events/cut_recording.hpp"
#include "tactile/labels/lit_rate.hpp"
#include "tactile/labels/run_bursts.hpp"
#include "tactile/labels/unlogged_lift.hpp"

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

/// The bursts of runs one after another.
struct Groups {
  std::vector<Bursts> runs;
  Bursts brief;  ///< in no run: too brief and small for a touch
};

/// Divides bursts where they are quiet for `quiet_bins`. A group of slow rises alone joins the nearer neighbour.
Groups grouped(const EventRate& rate, const Bursts& all, std::size_t quiet_bins) {
  Groups groups;
  for (const Burst& burst : all) {
    if (!burst.slow && alignment::is_after_effect(burst, rate, all)) {
      groups.brief.push_back(burst);
    } else if (groups.runs.empty() || burst.begin - std::min(burst.begin, groups.runs.back().back().end) >= quiet_bins) {
      groups.runs.push_back({burst});
    } else {
      groups.runs.back().push_back(burst);
    }
  }
  const auto is_slow = [](const Bursts& run) {
    return std::all_of(run.begin(), run.end(), [](const Burst& b) { return b.slow; });
  };
  for (std::size_t i = 0; i < groups.runs.size();) {
    if (!is_slow(groups.runs[i]) || groups.runs.size() == 1) {
      ++i;
      continue;
    }
    const bool joins_next =
        i == 0 || (i + 1 < groups.runs.size() && groups.runs[i + 1].front().begin - groups.runs[i].back().end <
                                                     groups.runs[i].front().begin - groups.runs[i - 1].back().end);
    const std::size_t into = joins_next ? i + 1 : i - 1;
    Bursts& other = groups.runs[into];
    other.insert(joins_next ? other.begin() : other.end(), groups.runs[i].begin(), groups.runs[i].end());
    groups.runs.erase(groups.runs.begin() + static_cast<std::ptrdiff_t>(i));
  }
  return groups;
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

/// The lift of a run by the IMU, if it shows one.
std::optional<std::vector<labels::ArmMove>> felt_lift(std::span<const events::ImuSample> imu, const EventRate& rate,
                                                      const Bursts& run, std::span<const double> undoes) {
  constexpr microseconds around = 1s;
  const auto at = [&](CameraTime t) {
    return std::lower_bound(imu.begin(), imu.end(), t, [](const events::ImuSample& s, CameraTime time) { return s.t < time; });
  };
  const std::span<const events::ImuSample> samples(at(before(rate.begin_of(run.front().begin), around)),
                                                   at(after(rate.begin_of(run.back().end), around)));
  std::vector<bool> may_slip;
  for (std::size_t i = 0; i < run.size(); ++i)
    may_slip.push_back(i > 0 && undoes[i] <= labels::TouchesOptions{}.releases && !alignment::is_after_effect(run[i], rate, run));
  const auto lift = labels::unlogged_lift(samples, {}, rate, run, may_slip);
  return lift ? std::optional(std::vector{lift->move}) : std::nullopt;
}

/// What the bursts of each run are, by the arm's motions, their order and what they change in the picture.
std::vector<SeenTouch> classified(events::RecordingReader& recording, std::int32_t stream, const EventRate& rate,
                                  const std::vector<Bursts>& runs, const DeviceClockSearch& robot) {
  labels::LitRateOptions options;
  options.most_places = 0;  // only what a burst undoes is needed
  options.margin = 100ms;
  Bursts all;
  for (const Bursts& run : runs) {
    options.fresh_at.push_back(all.size());
    all.insert(all.end(), run.begin(), run.end());
  }
  std::vector<double> undoes;
  for (const labels::LitRate& lit : labels::lit_rates(recording, stream, rate, all, options)) undoes.push_back(lit.undoes);
  const std::vector<events::ImuSample> imu = robot.lifts ? std::vector<events::ImuSample>() : imu_of(recording);
  std::vector<SeenTouch> touches;
  std::size_t next = 0;
  for (const Bursts& run : runs) {
    const std::span<const double> undoes_of_run = std::span(undoes).subspan(next, run.size());
    const auto lifts = robot.lifts ? robot.lifts : felt_lift(imu, rate, run, undoes_of_run);
    const auto kinds = labels::kinds_of(rate, run, lifts, robot.taps.value_or(std::vector<labels::ArmMove>()), undoes_of_run);
    for (std::size_t i = 0; i < run.size(); ++i)
      touches.push_back({.begin = rate.begin_of(run[i].begin), .end = rate.begin_of(run[i].end), .kind = kinds[i]});
    next += run.size();
  }
  return touches;
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
  if (source.robot) proposal.robot = find_robot_clock(source, recording, rate, quiet);
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
  const Bursts all =
      labels::joined_and_slow_bursts(recording, proposal.event_stream, rate, activity.quiet, std::move(activity.bursts),
                                     proposal.robot.lifts.value_or(std::vector<labels::ArmMove>()), activity.pauses);

  const auto quiet_bins = static_cast<std::size_t>(std::max<std::int64_t>(1, options.quiet / rate.bin));
  const Groups groups = grouped(rate, all, quiet_bins);
  report_progress(progress, 3, 4, name + ": touches");
  proposal.touches = classified(recording, proposal.event_stream, rate, groups.runs, proposal.robot);
  std::vector<CameraTime> cuts;
  for (std::size_t i = 1; i < groups.runs.size(); ++i)
    cuts.push_back(rate.begin_of(middle_of_quiet(groups.runs[i - 1].back().end, groups.runs[i].front().begin, groups.brief)));
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

std::size_t count_of(const ProposedRun& run, labels::BurstKind kind) {
  return static_cast<std::size_t>(
      std::count_if(run.touches.begin(), run.touches.end(), [&](const SeenTouch& touch) { return touch.kind == kind; }));
}

std::string_view name_of(labels::BurstKind kind) {
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
    json["presses"] = proposal.looked_for_touches ? nlohmann::json(count_of(run, labels::BurstKind::press)) : nlohmann::json();
    json["slips"] = proposal.looked_for_touches ? nlohmann::json(count_of(run, labels::BurstKind::slip)) : nlohmann::json();
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
