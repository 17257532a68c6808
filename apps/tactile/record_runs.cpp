#include "record_runs.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <optional>
#include <thread>
#include <utility>

#include "command.hpp"
#include "input_lines.hpp"
#include "interruption.hpp"
#include "quantity_text.hpp"
#include "tactile/capture/new_run.hpp"
#include "tactile/core/duration_units.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/error_text.hpp"
#include "tactile/core/host_clock.hpp"
#include "tactile/core/runs_below.hpp"
#include "text_table.hpp"

namespace tactile::cli {
namespace {

using Steady = std::chrono::steady_clock;

/// Names the sessions: runs that share one start of camera and controller. The camera starts with this program; the monitor
/// counts the starts of the controller's clock. While the robot is not connected this is unknown: such a run is a session of its
/// own.
class SessionId {
 public:
  explicit SessionId(const std::string& name) {
    const std::int64_t now_us = us_of(host_now());
    const auto seconds = static_cast<std::time_t>(now_us / 1'000'000);
    std::tm utc{};
    gmtime_r(&seconds, &utc);
    base_ = fmt::format("{}{}{:04}{:02}{:02}-{:02}{:02}{:02}-{:06}", name, name.empty() ? "" : "-", utc.tm_year + 1900,
                        utc.tm_mon + 1, utc.tm_mday, utc.tm_hour, utc.tm_min, utc.tm_sec, now_us % 1'000'000);
  }
  std::string of(const robot::RobotMonitor* robot) {
    if (robot == nullptr) return base_;
    const bool is_known = clock_is_known(*robot);
    const robot::RobotMonitorState state = robot->state();
    if (!is_known || !state.connected) return name_of(++names_);
    if (state.clock_starts != clock_starts_) present_ = ++names_;
    clock_starts_ = state.clock_starts;
    return name_of(present_);
  }

 private:
  /// A robot sends its clock with its first package after connecting.
  static bool clock_is_known(const robot::RobotMonitor& robot) {
    const Steady::time_point deadline = Steady::now() + std::chrono::seconds(1);
    while (!robot.newest("timestamp")) {
      if (!robot.state().connected || Steady::now() > deadline) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return true;
  }
  std::string name_of(int number) const { return number == 1 ? base_ : fmt::format("{}-{}", base_, number); }

  std::string base_;
  std::uint64_t clock_starts_ = 0;  ///< of the present session; 0 if there is none
  int names_ = 0, present_ = 0;
};

std::optional<bool> newest(const capture::RunRecorder& recorder, const capture::RobotBit& bit) {
  const std::optional<double> value = recorder.robot()->newest(bit.field);
  return value ? std::optional<bool>(bit.is_high(*value)) : std::nullopt;
}

std::string megabytes(std::uint64_t bytes) { return fmt::format("{:.1f} MB", 1e-6 * static_cast<double>(bytes)); }

/// Elements of every type, video frames and packages of the robot that were sent, but are in no file.
std::string drops_text(const capture::RunDrops& drops) {
  const capture::LostElements total = drops.total();
  if (total.packets + total.events + total.others == 0) return "0";
  std::string text = counted(total.events, "event");
  if (total.others > 0) text += ", " + counted(total.others, "other element");
  if (total.packets > 0) text += " (" + counted(total.packets, "packet") + ")";
  return text;
}

class SessionRecording {
 public:
  SessionRecording(capture::RunRecorder& recorder, const RunsToRecord& wanted, LiveLine& line)
      : recorder_(recorder), wanted_(wanted), plan_(wanted.plan), line_(line), session_(plan_.name) {}

  RecordedRuns all() {
    std::string error;
    try {
      record_all();
      if (!done_.empty() && !done_.back().errors.empty()) error = done_.back().errors.front();
    } catch (const std::exception& e) {  // the runs so far are reported nevertheless
      line_.clear();
      error = sentence_of(e);
    }
    return {std::move(done_), error};
  }

 private:
  int runs_there(std::size_t object_index) const {
    return capture::complete_runs(wanted_.data, plan_, plan_.objects[object_index].name);
  }

  void record_all();
  RecordChoice wait_to_begin();
  std::string question() const;
  std::vector<OfferedChoice> offered() const;
  std::optional<RecordChoice> choice_in(const std::string& line) const;
  bool record_one();
  void discard_last();
  void draw(const RunFolder& run, const capture::RunState& state);
  void ask_on_page(std::vector<OfferedChoice> offered) const {
    if (wanted_.choices != nullptr) wanted_.choices->ask(std::move(offered));
  }
  std::optional<RecordChoice> chosen_on_page() const {
    return wanted_.choices != nullptr ? wanted_.choices->chosen() : std::nullopt;
  }
  /// Whether the end of standard input ends nothing, because a person can choose on the page. At the end of the list only if one
  /// has: else a session that reads its answers from a file would never end.
  bool page_leads(bool at_end) const { return wanted_.choices != nullptr && (!at_end || wanted_.choices->was_used()); }
  void show(RecordMoment moment) const {
    moment.recorder = &recorder_;
    if (wanted_.watch) wanted_.watch(moment);
  }

  capture::RunRecorder& recorder_;
  const RunsToRecord& wanted_;
  const capture::SessionPlan& plan_;
  LiveLine& line_;
  SessionId session_;
  InputLines answers_;
  bool has_reported_end_ = false;  ///< of standard input
  std::size_t object_index_ = 0;
  std::vector<capture::RunSummary> done_;
  capture::RisingEdge start_;  ///< kept from run to run: it may rise while a run is being closed
  Steady::time_point drawn_{};
  std::uint64_t drawn_events_ = 0;
};

void SessionRecording::record_all() {
  if (wanted_.is_session && is_there(wanted_.data)) {
    const RunsBelow below = look_for_runs(wanted_.data);
    for (const auto* sentences : {&below.misnamed, &below.unreadable}) {
      for (const std::string& sentence : *sentences) line_.warn(sentence);
    }
  }
  while (object_index_ <= plan_.objects.size()) {
    const RecordChoice choice = wait_to_begin();
    ask_on_page({});
    switch (choice) {
      case RecordChoice::start:
        if (!record_one()) return;
        break;
      case RecordChoice::redo:
        discard_last();
        break;
      case RecordChoice::skip:
        ++object_index_;
        break;
      case RecordChoice::stop:
      case RecordChoice::end:
        return;
    }
  }
}

std::string SessionRecording::question() const {
  const std::string redo = done_.empty() ? "" : fmt::format(" r repeats {},", done_.back().run.name());
  if (object_index_ == plan_.objects.size())
    return done_.empty() ? "End of the list. Enter ends."
                         : fmt::format("End of the list. Enter ends, r and Enter repeats {}.", done_.back().run.name());
  const capture::SessionPlan::Object& object = plan_.objects[object_index_];
  const std::string start = plan_.start_on ? plan_.start_on->text() + " starts" : "Enter starts";
  return fmt::format("{}, run {} of {}: {}; followed by Enter,{} s skips the object, q ends.", object.name,
                     runs_there(object_index_) + 1, object.runs, start, redo);
}

/// What the page offers while the next run is waited for.
std::vector<OfferedChoice> SessionRecording::offered() const {
  std::vector<OfferedChoice> choices;
  const bool at_end = object_index_ == plan_.objects.size();
  const std::string object = at_end ? "" : plan_.objects[object_index_].name;
  if (!at_end && !plan_.start_on)
    choices.push_back({RecordChoice::start, fmt::format("Start {}, run {}", object, runs_there(object_index_) + 1)});
  if (!done_.empty()) choices.push_back({RecordChoice::redo, "Redo " + done_.back().run.name()});
  if (!at_end) choices.push_back({RecordChoice::skip, "Skip " + object});
  choices.push_back({RecordChoice::end, "End the session"});
  return choices;
}

/// The choice that a line of standard input is; nothing if it is none.
std::optional<RecordChoice> SessionRecording::choice_in(const std::string& line) const {
  const bool at_end = object_index_ == plan_.objects.size();
  if (line == "q" || (line.empty() && at_end)) return RecordChoice::end;
  if (line == "r" && !done_.empty()) return RecordChoice::redo;
  if (line == "s" && !at_end) return RecordChoice::skip;
  if (line.empty() && !plan_.start_on) return RecordChoice::start;
  return std::nullopt;
}

/// Skips the objects that have all their runs. At the end of the list a question allows redoing the last run.
RecordChoice SessionRecording::wait_to_begin() {
  if (interrupted()) return RecordChoice::end;
  if (!wanted_.is_session && !plan_.start_on) return done_.empty() ? RecordChoice::start : RecordChoice::end;
  if (!wanted_.is_session && !done_.empty()) return RecordChoice::end;
  if (wanted_.is_session) {
    while (object_index_ < plan_.objects.size() && runs_there(object_index_) >= plan_.objects[object_index_].runs)
      ++object_index_;
  }
  const bool at_end = object_index_ == plan_.objects.size();
  if (at_end && (done_.empty() || plan_.start_on)) return RecordChoice::end;
  const std::string words = wanted_.is_session ? question() : "waits for " + plan_.start_on->text();
  line_.inform(words);
  ask_on_page(wanted_.is_session ? offered() : std::vector<OfferedChoice>());
  recorder_.discard();
  bool has_reported_high = false;
  for (;;) {
    show({.state = "waiting", .words = words});
    if (interrupted()) return RecordChoice::end;
    if (const std::string gone = recorder_.gone(); !gone.empty() && !at_end) {
      if (done_.empty() || gone != "source ended") throw Error(gone + "; expected a source that continues until the last run");
      line_.warn(gone + ": no further run can be recorded");
      return RecordChoice::end;
    }
    if (plan_.start_on) {
      const std::optional<bool> high = newest(recorder_, *plan_.start_on);
      if (start_.rises(high)) return RecordChoice::start;
      if (high.value_or(false) && !std::exchange(has_reported_high, true))
        line_.inform(plan_.start_on->text() + " is high already: it must fall before it can start a run");
    }
    const std::chrono::milliseconds patience(plan_.start_on ? 2 : 50);
    if (!wanted_.is_session) {
      std::this_thread::sleep_for(patience);
      continue;
    }
    const std::optional<std::string> line = answers_.next(patience);
    if (line) {
      if (const auto choice = choice_in(*line)) return *choice;
      line_.inform(fmt::format("'{}' is no answer here. {}", *line, question()));
    } else if (const auto choice = chosen_on_page()) {
      return *choice;
    } else if (answers_.ended() && !plan_.start_on) {
      if (!page_leads(at_end)) return RecordChoice::end;
      if (!std::exchange(has_reported_end_, true))
        line_.inform("standard input has ended: choose on the page; Ctrl-C ends the session");
    }
  }
}

void SessionRecording::discard_last() {
  const capture::RunSummary last = done_.back();
  done_.pop_back();
  line_.inform(fmt::format("{} is now {}", last.run.name(), capture::discard_run(last.run).filename().string()));
  for (std::size_t i = 0; i < plan_.objects.size(); ++i) {
    if (plan_.objects[i].name == last.run.object) object_index_ = i;
  }
}

/// False if nothing more shall be recorded.
bool SessionRecording::record_one() {
  const int counted_before = wanted_.is_session ? runs_there(object_index_) : 0;
  capture::RunRequest request{.run = capture::make_run_folder(wanted_.data, plan_.objects[object_index_].name, wanted_.run),
                              .session = session_.of(recorder_.robot()),
                              .duration = {},
                              .settings = wanted_.settings};
  if (plan_.duration_s) request.duration = microseconds(static_cast<std::int64_t>(1e6 * *plan_.duration_s));
  capture::RisingEdge stop;
  if (plan_.stop_on) stop.rises(newest(recorder_, *plan_.stop_on).value_or(false));
  if (recorder_.robot() != nullptr && !recorder_.robot()->state().connected)
    line_.warn(request.run.name() + " begins without the robot: its motion is not in the log until it is connected again");
  recorder_.begin(request);
  drawn_ = Steady::now();
  drawn_events_ = 0;
  const bool enter_ends = wanted_.is_session && !plan_.duration_s && !plan_.stop_on;
  const char* how_it_ends = enter_ends ? ", Enter ends it" : wanted_.is_session || plan_.duration_s ? "" : ", Ctrl-C ends it";
  const std::string words = fmt::format("recording {}{}", request.run.folder.string(), how_it_ends);
  line_.inform(words);
  ask_on_page({{RecordChoice::stop, "Stop " + request.run.name()}});
  bool has_reported_drops = false;
  std::string why;
  while (why.empty()) {
    if (plan_.start_on) start_.rises(newest(recorder_, *plan_.start_on));
    const capture::RunState state = recorder_.state();
    draw(request.run, state);
    show({.state = "recording", .run = request.run.name(), .words = words, .now = &state});
    if (!has_reported_drops && state.drops.queue_full.packets > 0) {
      has_reported_drops = true;
      line_.warn(request.run.name() + ": writing is too slow, packets are dropped and counted");
    }
    why = state.ended;
    if (!why.empty()) break;
    if (interrupted()) {
      why = "interrupted";
    } else if (plan_.stop_on && stop.rises(newest(recorder_, *plan_.stop_on))) {
      why = "stopped by " + plan_.stop_on->text();
    } else if (chosen_on_page()) {
      why = "stopped on the page";
    } else if (enter_ends && answers_.next(std::chrono::milliseconds(20))) {
      why = "stopped by Enter";
    } else if (!enter_ends) {
      std::this_thread::sleep_for(std::chrono::milliseconds(plan_.stop_on ? 2 : 20));
    }
  }
  ask_on_page({});
  line_.clear();
  done_.push_back(recorder_.end(why));
  const capture::RunSummary& run = done_.back();
  for (std::size_t i = 1; i < run.errors.size(); ++i) line_.warn(run.errors[i]);
  if (run.robot && run.robot->rows == 0) line_.warn(run.run.name() + ": no data came from the robot: robot.csv has no row");
  if (wanted_.is_session || !line_.draws()) {
    line_.inform(fmt::format("{}: {} in {:.1f} s, {}, dropped {}, ended by: {}", run.run.name(), counted(run.events, "event"),
                             in_s(run.elapsed), megabytes(run.bytes), drops_text(run.drops), run.ended));
  }
  if (wanted_.is_session && runs_there(object_index_) == counted_before)
    line_.inform(fmt::format("{} is kept, but does not count for the plan: it was interrupted", run.run.name()));
  return run.errors.empty() && !interrupted();
}

void SessionRecording::draw(const RunFolder& run, const capture::RunState& state) {
  const Steady::time_point now = Steady::now();
  if (!line_.draws() || now - drawn_ < std::chrono::seconds(1)) return;
  const double passed = std::chrono::duration<double>(now - drawn_).count();
  std::string text = wanted_.is_session ? run.name() + "  " : "";
  text += fmt::format("{}  {}  {}", clock_text(in_s(state.elapsed)),
                      rate_text(static_cast<double>(state.events - drawn_events_) / passed), megabytes(state.bytes));
  // Losses come first, because a narrow terminal cuts the line at its right end.
  text += fmt::format("  dropped {}", drops_text(state.drops));
  if (state.video && state.video->dropped > 0) text += fmt::format(", {}", counted(state.video->dropped, "frame"));
  text += fmt::format("  queue {}", megabytes(state.queue_bytes));
  if (state.robot) text += state.robot->connected ? fmt::format("  robot {:.0f} Hz", state.robot->rate_hz) : "  robot lost";
  if (state.video)
    text += state.video->running ? fmt::format("  video {:.1f} fps", state.video->frames_per_second) : "  video lost";
  drawn_ = now;
  drawn_events_ = state.events;
  line_.draw(text);
}

}  // namespace

RecordedRuns record_runs(capture::RunRecorder& recorder, const RunsToRecord& wanted, LiveLine& line) {
  return SessionRecording(recorder, wanted, line).all();
}

std::string text_of(const capture::RunSummary& run) {
  const double span_s = in_s(run.events_span);
  const std::string rate = span_s > 0 ? ", " + rate_text(static_cast<double>(run.events) / span_s) : "";
  std::vector<std::pair<std::string, std::string>> lines{
      {"events", fmt::format("{} in {}{}", run.events, duration_text(run.events_span), rate)}};
  if (run.imu_samples > 0) lines.emplace_back("imu", counted(run.imu_samples, "sample"));
  if (run.triggers > 0) lines.emplace_back("triggers", std::to_string(run.triggers));
  if (run.frames > 0) lines.emplace_back("frames", fmt::format("{} of the camera", run.frames));
  lines.emplace_back("files", fmt::format("{}, recorded in {}", bytes_text(run.bytes), duration_text(run.elapsed)));
  lines.emplace_back("dropped", drops_text(run.drops));
  if (run.robot) {
    lines.emplace_back("robot", fmt::format("{}, {}, {} missing", counted(run.robot->rows, "row"),
                                            counted(run.robot->gaps, "gap"), counted(run.robot->missing, "package")));
  }
  if (run.video) {
    lines.emplace_back("video", fmt::format("{}, {} dropped", counted(run.video->frames, "frame"), run.video->dropped));
  }
  lines.emplace_back("session", run.session);
  lines.emplace_back("ended", run.ended);
  std::string text = fmt::format("{}{}{}\n", run.run.folder.string(), run.simulated ? " (simulated)" : "",
                                 run.complete ? "" : " (NOT COMPLETE)");
  const std::string list = text_list(lines);
  for (std::size_t begin = 0; begin < list.size();) {
    const std::size_t end = std::min(list.find('\n', begin), list.size() - 1) + 1;
    text += "  " + list.substr(begin, end - begin);
    begin = end;
  }
  return text;
}

nlohmann::json json_of(const capture::RunSummary& run) {
  const double events_s = in_s(run.events_span);
  nlohmann::json json = {
      {"folder", run.run.folder.string()},
      {"object", run.run.object},
      {"run", run.run.run},
      {"session", run.session},
      {"simulated", run.simulated},
      {"complete", run.complete},
      {"ended", run.ended},
      {"errors", run.errors},
      {"events", run.events},
      {"others", run.others},
      {"imu_samples", run.imu_samples},
      {"triggers", run.triggers},
      {"frames", run.frames},
      {"elapsed_s", in_s(run.elapsed)},
      {"duration_s", in_s(run.span)},
      {"events_per_s", events_s > 0 ? nlohmann::json(static_cast<double>(run.events) / events_s) : nlohmann::json()},
      {"bytes", run.bytes},
      {"dropped", json_of(run.drops)},
      {"robot", nullptr},
      {"video", nullptr}};
  if (run.robot) {
    json["robot"] = {{"rows", run.robot->rows},
                     {"gaps", run.robot->gaps},
                     {"missing", run.robot->missing},
                     {"reconnects", run.robot->reconnects},
                     {"controller", run.robot->controller}};
  }
  if (run.video) json["video"] = {{"frames", run.video->frames}, {"dropped", run.video->dropped}};
  return json;
}

}  // namespace tactile::cli
