#include "tactile/splitting/split_proposal.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <utility>

#include "tactile/alignment/arm_motion.hpp"
#include "tactile/alignment/run_signals.hpp"
#include "tactile/core/error.hpp"
#include "tactile/events/cut_recording.hpp"
#include "tactile/robot/robot_log.hpp"
#include "tactile/splitting/long_course.hpp"

namespace tactile::splitting {
namespace {

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

alignment::EventRate rate_of(events::RecordingReader& recording, std::int32_t stream) {
  alignment::EventRateOptions options;
  options.bin = 8ms;
  options.hot_pixel_hz = 50.0;  // pixels at a marker fire in every run, so only those that fire much faster are hot
  options.longest = std::chrono::hours(48);
  return alignment::event_rate(recording, stream, options);
}

/// The robot's log; without a row if there is none. Sets the proposal's clock of it, if it is known.
robot::RobotLogFile robot_log_of(SplitProposal& proposal, const SplitSource& source) {
  if (!source.robot) return {};
  robot::RobotLogFile log = robot::read_robot_log(*source.robot, {.arm = {}, .columns = source.robot_columns});
  proposal.robot = known_robot_clock(source, log);
  return log;
}

/// Why no part of the recording shows the log's clock.
std::string why_no_clock(const robot::RobotLogFile& log, const alignment::EventRate& rate) {
  if (alignment::are_too_far_apart(rate.begin, log.pieces.front().states.front().t))
    return "the two clocks lie further apart than 64 bits of microseconds";
  if (!alignment::arm_motion(log.pieces.front())) return "the log has a single row, or spans more than 4.6 h";
  return "log and recording show no common motion";
}

/// What happens in the recording. Sets the robot's clock, if it is not known.
LongCourse course_of(SplitProposal& proposal, robot::RobotLogFile log, events::RecordingReader& recording,
                     const alignment::EventRate& rate, const LongCourseOptions& options, const ProgressCallback& progress) {
  const bool is_sought = !log.pieces.empty() && !proposal.robot.clock && proposal.robot.why_not.empty();
  std::string why_not = is_sought ? why_no_clock(log, rate) : std::string();
  LongCourse course =
      long_course(recording, proposal.event_stream, rate, std::move(log), proposal.robot.clock, options, progress);
  if (is_sought) proposal.robot.clock = course.robot;
  if (!proposal.robot.clock && is_sought) proposal.robot.why_not = std::move(why_not);
  return course;
}

std::vector<SeenTouch> touches_in(const LongCourse& course) {
  std::vector<SeenTouch> touches;
  for (const labels::LikelyTouch& touch : course.touches)
    touches.push_back({touch.start.at, touch.end.at, touch.touch == Touch::press ? SeenKind::press : SeenKind::slip});
  for (const TouchInterval& release : course.releases) touches.push_back({release.start, release.end, SeenKind::release});
  std::stable_sort(touches.begin(), touches.end(), [](const SeenTouch& a, const SeenTouch& b) { return a.begin < b.begin; });
  return touches;
}

/// In rests that end a run. Between two cuts there is a touch, and before the first and after the last one.
std::vector<CameraTime> cuts_in(const LongCourse& course, const std::vector<SeenTouch>& touches,
                                const LongCourseOptions& options) {
  std::vector<CameraTime> cuts;
  for (const labels::LikelyRest& rest : course.rests) {
    if (!ends_run(rest, options)) continue;
    const auto next =
        std::find_if(touches.begin(), touches.end(), [&](const SeenTouch& one) { return one.begin >= rest.middle(); });
    const bool separates =
        next != touches.begin() && next != touches.end() && (cuts.empty() || std::prev(next)->begin >= cuts.back());
    if (separates) cuts.push_back(rest.middle());
  }
  return cuts;
}

}  // namespace

SplitProposal propose_runs(const SplitSource& source, events::RecordingReader& recording, const ProposeOptions& options,
                           const ProgressCallback& progress) {
  const std::string name = recording.file().filename().string();
  SplitProposal proposal;
  proposal.event_stream = events::event_stream(recording, options.stream).id;
  proposal.quiet_needed = options.course.quiet;
  report_progress(progress, 0, 1, name + ": event rate");
  const alignment::EventRate rate = rate_of(recording, proposal.event_stream);
  proposal.first = rate.begin;
  proposal.last = rate.last;
  const LongCourse course = course_of(proposal, robot_log_of(proposal, source), recording, rate, options.course, progress);
  if (source.video) proposal.film = find_film_clock(source);
  proposal.quiet_per_s = course.quiet_per_s;
  proposal.touches = touches_in(course);
  proposal.looked_for_touches = true;
  std::vector<CameraTime> cuts = cuts_in(course, proposal.touches, options.course);
  return with_cuts(std::move(proposal), recording, std::move(cuts));
}

SplitProposal proposal_with(const SplitSource& source, events::RecordingReader& recording,
                            const std::vector<microseconds>& after_first, const ProposeOptions& options,
                            const ProgressCallback& progress) {
  SplitProposal proposal;
  proposal.event_stream = events::event_stream(recording, options.stream).id;
  const Extent extent = extent_of(recording, proposal.event_stream);
  proposal.first = extent.first;
  proposal.last = extent.last;
  std::vector<CameraTime> cuts(after_first.size());
  std::transform(after_first.begin(), after_first.end(), cuts.begin(), [&](microseconds t) { return after(extent.first, t); });
  proposal = with_cuts(std::move(proposal), recording, std::move(cuts));
  robot::RobotLogFile log = robot_log_of(proposal, source);
  if (source.robot && !proposal.robot.clock && proposal.robot.why_not.empty())
    course_of(proposal, std::move(log), recording, rate_of(recording, proposal.event_stream), options.course, progress);
  if (source.video) proposal.film = find_film_clock(source);
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

std::size_t count_of(const ProposedRun& run, SeenKind kind) {
  return static_cast<std::size_t>(
      std::count_if(run.touches.begin(), run.touches.end(), [&](const SeenTouch& touch) { return touch.kind == kind; }));
}

std::string_view name_of(SeenKind kind) {
  constexpr std::array<std::string_view, 3> names{"press", "slip", "release"};
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
    json["presses"] = proposal.looked_for_touches ? nlohmann::json(count_of(run, SeenKind::press)) : nlohmann::json();
    json["slips"] = proposal.looked_for_touches ? nlohmann::json(count_of(run, SeenKind::slip)) : nlohmann::json();
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
