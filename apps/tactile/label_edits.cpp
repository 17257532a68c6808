#include "label_edits.hpp"

#include <fmt/core.h>
#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <utility>

#include "label_pictures.hpp"
#include "run_places.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/error_text.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/text.hpp"
#include "tactile/labels/saved_labels.hpp"
#include "text_table.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;

/// The part of an edit after the run.
struct EditOfRun {
  TypedEdit typed;
  std::string rest;         ///< "press-1.start=1.2345"; empty if the whole run is meant
  bool of_pattern = false;  ///< the runs of a pattern that have nothing to edit are left out
};

struct RunEdits {
  RunFolder run;
  std::vector<EditOfRun> edits;
};

[[noreturn]] void refuse(const TypedEdit& typed, const std::string& why) {
  throw Error(fmt::format("{} {}: {}", typed.option, shown_text(typed.text), why));
}

bool is_run_folder(const fs::path& folder) { return is_there(folder / "events.aedat4"); }

/// The run of this name: a path, or a name such as "fan/01" below one of the places.
std::optional<RunFolder> run_named(const std::string& name, const std::vector<std::string>& places) {
  if (name.empty()) return std::nullopt;
  if (is_run_folder(name)) return named_run_at(name);
  for (const std::string& place : places) {
    if (is_run_folder(fs::path(place) / name)) return named_run_at(fs::path(place) / name);
    if (!is_run_folder(place)) continue;
    if (RunFolder run = named_run_at(place); run.name() == name) return run;
  }
  return std::nullopt;
}

/// The run, which ends at a colon or with the text, and the rest. A path may have colons, too.
std::pair<RunFolder, std::string> run_and_rest(const TypedEdit& typed, const std::vector<std::string>& places) {
  for (std::size_t end = typed.text.find(':');; end = typed.text.find(':', end + 1)) {
    if (auto run = run_named(typed.text.substr(0, end), places))
      return {std::move(*run), end == std::string::npos ? "" : typed.text.substr(end + 1)};
    if (end == std::string::npos) break;
  }
  refuse(typed,
         fmt::format("names no run; expected a run's folder, or a name such as fan/01 of a run in {}", fmt::join(places, ", ")));
}

/// Whether it names its runs by a pattern. A run of this very name comes first.
bool is_pattern(const TypedEdit& typed, const std::vector<std::string>& places) {
  const std::string name = typed.text.substr(0, typed.text.find(':'));
  return name.find_first_of("*?") != std::string::npos && !run_named(name, places);
}

/// The runs below the places whose names, or folders, match the pattern before the first colon, and the text after it.
std::pair<std::vector<RunFolder>, std::string> runs_and_rest(const TypedEdit& typed, const std::vector<std::string>& places) {
  if (typed.option != "--confirm" && typed.option != "--lift")
    refuse(typed, "names more than one run; expected one run: only --confirm and --lift take a pattern");
  const std::size_t end = typed.text.find(':');
  const std::string pattern = typed.text.substr(0, end);
  std::vector<RunFolder> runs = runs_in(places, LeftOutFolders::say_nothing).runs;
  std::erase_if(runs, [&](const RunFolder& run) {
    return !is_there(run.labels()) ||
           (::fnmatch(pattern.c_str(), run.name().c_str(), 0) != 0 && ::fnmatch(pattern.c_str(), run.folder.c_str(), 0) != 0);
  });
  if (runs.empty())
    refuse(typed,
           fmt::format("matches no run with labels; expected a pattern of runs in {}, such as 'fan/*'", fmt::join(places, ", ")));
  return {std::move(runs), end == std::string::npos ? "" : typed.text.substr(end + 1)};
}

std::vector<RunEdits> edits_by_run(const std::vector<TypedEdit>& edits, const std::vector<std::string>& places) {
  std::vector<RunEdits> runs;
  const auto add = [&](RunFolder run, EditOfRun edit) {
    const auto found = std::find_if(runs.begin(), runs.end(), [&folder = run.folder](const RunEdits& other) {
      std::error_code unknown;
      return fs::equivalent(other.run.folder, folder, unknown);
    });
    RunEdits& edits_of_run = found == runs.end() ? runs.emplace_back(RunEdits{.run = std::move(run), .edits = {}}) : *found;
    edits_of_run.edits.push_back(std::move(edit));
  };
  for (const TypedEdit& typed : edits) {
    if (is_pattern(typed, places)) {
      auto [matching, rest] = runs_and_rest(typed, places);
      for (RunFolder& run : matching) add(std::move(run), {.typed = typed, .rest = rest, .of_pattern = true});
    } else {
      auto [run, rest] = run_and_rest(typed, places);
      add(std::move(run), {.typed = typed, .rest = std::move(rest)});
    }
  }
  return runs;
}

CameraTime time_in(const TypedEdit& typed, std::string_view seconds, const labels::RecordingSpan& recording) {
  const auto read = labels::seconds_in(seconds);
  if (!read) {
    refuse(typed, fmt::format("{} is no time; expected seconds from the run's first event, such as 1.2345", shown_text(seconds)));
  }
  return after(recording.first, microseconds{read->us});
}

Touch class_in(const TypedEdit& typed, std::string_view name) {
  if (name != "press" && name != "slip") refuse(typed, fmt::format("{} is no class; expected press or slip", shown_text(name)));
  return touch_named(name);
}

/// "press-1.start=1.2345", "press-1.class=slip"
labels::LabelEdit setting_in(const TypedEdit& typed, std::string_view rest, const labels::RecordingSpan& recording) {
  const std::size_t equals = rest.find('='), dot = rest.substr(0, equals).rfind('.');
  if (equals == std::string_view::npos || dot == std::string_view::npos || dot == 0)
    refuse(typed, "names no setting; expected RUN:INTERVAL.start=SECONDS, RUN:INTERVAL.end=SECONDS or RUN:INTERVAL.class=slip");
  const std::string id(rest.substr(0, dot));
  const std::string_view what = rest.substr(dot + 1, equals - dot - 1), value = rest.substr(equals + 1);
  if (what == "class") return labels::ChangeClass{.id = id, .touch = class_in(typed, value)};
  if (what != "start" && what != "end")
    refuse(typed, fmt::format("{} cannot be set; expected start, end or class", shown_text(what)));
  return labels::MoveEnd{.id = id,
                         .which = what == "start" ? labels::IntervalEnd::start : labels::IntervalEnd::end,
                         .to = time_in(typed, value, recording)};
}

/// "press=1.2..1.9"
labels::LabelEdit addition_in(const TypedEdit& typed, std::string_view rest, const labels::RecordingSpan& recording) {
  const std::size_t equals = rest.find('='), dots = rest.find("..");
  if (equals == std::string_view::npos || dots == std::string_view::npos || dots < equals)
    refuse(typed, "describes no interval; expected RUN:press=START..END in seconds, such as fan/01:press=1.2..1.9");
  return labels::AddInterval{.touch = class_in(typed, rest.substr(0, equals)),
                             .start = time_in(typed, rest.substr(equals + 1, dots - equals - 1), recording),
                             .end = time_in(typed, rest.substr(dots + 2), recording)};
}

/// The flag of this key, or the only one with these words.
labels::LabelEdit lift_in(const TypedEdit& typed, const std::string& rest, const labels::Labels& labels) {
  std::vector<std::size_t> meant;
  std::vector<std::string> standing;
  for (std::size_t i = 0; i < labels.flags.size(); ++i) {
    const labels::LabelFlag& flag = labels.flags[i];
    if (flag.confirmed) continue;
    standing.push_back(shown_text(flag.key.empty() ? flag.reason : flag.key));
    if (!rest.empty() && (flag.key == rest || flag.reason.find(rest) != std::string::npos)) meant.push_back(i);
  }
  const auto has_key = [&](std::size_t i) { return labels.flags[i].key == rest; };
  if (const auto exact = std::find_if(meant.begin(), meant.end(), has_key); exact != meant.end()) return labels::LiftFlag{*exact};
  if (meant.size() == 1) return labels::LiftFlag{meant.front()};
  refuse(typed, standing.empty() ? std::string("the run has no flag; expected a flagged run")
                                 : fmt::format("{} flags have these words; expected words of one of {}", meant.size(),
                                               fmt::join(standing, ", ")));
}

/// Of a run that a pattern names: whatever it means that is still open.
std::vector<labels::LabelEdit> open_edits(const EditOfRun& edit, const labels::Labels& labels) {
  const auto is_open = [](const auto& part) { return !part.confirmed; };
  std::vector<labels::LabelEdit> edits;
  if (edit.typed.option == "--lift") {
    for (std::size_t i = 0; i < labels.flags.size(); ++i) {
      const labels::LabelFlag& flag = labels.flags[i];
      const bool is_meant = !edit.rest.empty() && (flag.key == edit.rest || flag.reason.find(edit.rest) != std::string::npos);
      if (is_open(flag) && is_meant) edits.emplace_back(labels::LiftFlag{i});
    }
  } else if (edit.rest.empty()) {
    if (std::any_of(labels.flags.begin(), labels.flags.end(), is_open) ||
        std::any_of(labels.intervals.begin(), labels.intervals.end(), is_open))
      edits.emplace_back(labels::ConfirmRun{});
  } else {
    for (const labels::LabelledInterval& interval : labels.intervals)
      if (is_open(interval) && interval.id == edit.rest) edits.emplace_back(labels::ConfirmInterval{edit.rest});
  }
  return edits;
}

labels::LabelEdit edit_in(const EditOfRun& edit, const labels::Labels& labels, const labels::RecordingSpan& recording) {
  const std::string& option = edit.typed.option;
  if (option == "--confirm")
    return edit.rest.empty() ? labels::LabelEdit(labels::ConfirmRun{}) : labels::LabelEdit(labels::ConfirmInterval{edit.rest});
  if (option == "--set") return setting_in(edit.typed, edit.rest, recording);
  if (option == "--add") return addition_in(edit.typed, edit.rest, recording);
  if (option == "--lift") return lift_in(edit.typed, edit.rest, labels);
  if (edit.rest.empty()) refuse(edit.typed, "names no interval; expected RUN:INTERVAL, such as fan/01:press-1");
  return labels::RejectInterval{edit.rest};
}

/// @param made  how many edits
labels::Labels with_all(labels::Labels labels, const RunEdits& run, const labels::RecordingSpan& recording,
                        const labels::EditNote& note, std::size_t& made) {
  made = 0;
  for (const EditOfRun& edit : run.edits) {
    for (const labels::LabelEdit& one :
         edit.of_pattern ? open_edits(edit, labels) : std::vector{edit_in(edit, labels, recording)}) {
      try {
        labels = labels::edited(labels, one, recording, note);
      } catch (const Error& e) {
        refuse(edit.typed, e.what());
      }
      ++made;
    }
  }
  return labels;
}

nlohmann::json json_of(const RunFolder& run, const labels::HistoryEntry& entry) {
  return {{"run", run.name()}, {"who", entry.who}, {"when", entry.when}, {"what", entry.what}, {"why", entry.why}};
}

/// Edits of runs, to print.
struct Printed {
  nlohmann::json json = nlohmann::json::array();
  std::string text = {};

  void add(const RunFolder& run, const labels::HistoryEntry& entry, const char* before_it = "") {
    json.push_back(json_of(run, entry));
    text += fmt::format("{}: {}{}\n", run.name(), before_it, entry.what);
  }
};

/// A whole number from 1 on. @throws Error  naming the option
std::size_t count_in(const char* option, const std::string& text) {
  if (const auto count = whole_number_in(text); count && *count >= 1) return static_cast<std::size_t>(*count);
  throw Error(fmt::format("{} {}: is no number of edits; expected 1 or more, after the run: 'tactile label data/fan/01 {} 2'",
                          option, shown_text(text), option));
}

void undo_or_redo(const CommonArguments& common, bool is_undo, std::size_t count, const RunFolder& run, bool draw_pictures) {
  labels::SaveOutcome outcome;
  try {
    outcome = is_undo ? labels::save_undo(run, std::nullopt, count) : labels::save_redo(run, std::nullopt, count);
  } catch (const Error& e) {
    const std::string what = e.what();
    throw Error(what.find(run.name()) == std::string::npos ? run.name() + ": " + what : what);
  }
  const labels::Labels& labels = std::get<labels::VersionedLabels>(outcome).labels;
  const std::vector<labels::HistoryEntry>& entries = labels.history.entries;
  const std::size_t made = entries.size() - labels.history.undone;
  Printed printed;
  for (std::size_t i = 0; i < count; ++i) {
    if (is_undo) {
      printed.add(run, entries[made + count - 1 - i], "undone: ");
    } else {
      printed.add(run, entries[made - count + i], "redone: ");
    }
  }
  if (draw_pictures) draw_label_pictures(std::vector<RunAndLabels>{{run, labels}}, common.threads);
  print_result(common, {{is_undo ? "undone" : "redone", printed.json}}, printed.text);
}

void print_history(const CommonArguments& common, const RunsBelow& found) {
  nlohmann::json edits = nlohmann::json::array();
  std::vector<std::vector<std::string>> rows;
  std::vector<std::string> errors = found.unreadable;
  for (const RunFolder& run : found.runs) {
    try {
      const labels::EditHistory history = labels::read_versioned_labels(run).labels.history;
      for (std::size_t i = 0; i < history.entries.size(); ++i) {
        const labels::HistoryEntry& entry = history.entries[i];
        const bool is_undone = i + history.undone >= history.entries.size();
        edits.push_back(json_of(run, entry));
        edits.back()["undone"] = is_undone;
        edits.back()["can_be_undone"] = entry.change.has_value();
        rows.push_back({run.name(), entry.when.substr(0, 19), entry.who,
                        (is_undone ? "undone: " : "") + entry.what + (entry.why.empty() ? "" : " (" + entry.why + ")")});
      }
    } catch (const std::exception& e) {
      errors.push_back(sentence_of(e, run.name()));
    }
  }
  print_result(common, {{"history", edits}, {"failed", errors}},
               rows.empty() ? "no edits\n" : text_table({"run", "when (UTC)", "who", ""}, rows));
  end_with(errors);
}

}  // namespace

labels::EditNote LabelEditArguments::note() const { return {.who = who.empty() ? labels::system_user() : who, .why = why}; }

void add_label_edit_options(Command command, LabelEditArguments& arguments) {
  const auto add_edit = [&](const std::string& option, const std::string& value, const std::string& meaning) {
    const auto keep = [&arguments, option](const std::string& text) { arguments.edits.push_back({option, text}); };
    command.add_ordered_option(option, keep, meaning).type_name(value);
  };
  add_edit("--confirm", "RUN[:INTERVAL]",
           "Confirm a run or one interval: a person has looked at it, and it is right. 'fan/*' confirms all runs of fan");
  add_edit("--set", "EDIT",
           "Move a start or an end, in seconds from the run's first event, or change a class: fan/01:press-1.start=1.2345, "
           "fan/01:press-1.class=slip");
  add_edit("--add", "EDIT", "Add a press or slip: fan/01:press=1.2..1.9");
  add_edit("--reject", "EDIT", "Remove an interval, which is not found again: fan/01:press-1");
  add_edit("--lift", "EDIT",
           "Remove this flag: the label is right. Needs --why. Examples: fan/01:not completed, 'fan/*:has a gap'");
  command.add_option("--undo", arguments.undo, "Undo the last N edits of a run").type_name("N").value_is_optional("1");
  command.add_option("--redo", arguments.redo, "Redo the last N undone edits of a run").type_name("N").value_is_optional("1");
  command.add_flag("--history", arguments.history, "Print all edits");
  command.add_option("--who", arguments.who, "Name of the person who edits; default: the user's name on this system")
      .type_name("NAME");
  command.add_option("--why", arguments.why, "Reason of the edit, for the history").type_name("REASON");
  command.add_flag("--dry-run", arguments.dry_run, "Print what the edits or --import would change, and write nothing");
}

void check_edits(const LabelEditArguments& arguments, const std::vector<std::string>& others) {
  std::vector<std::string> work;
  if (!arguments.edits.empty()) work.push_back(arguments.edits.front().option);
  if (!arguments.undo.empty()) work.emplace_back("--undo");
  if (!arguments.redo.empty()) work.emplace_back("--redo");
  if (arguments.history) work.emplace_back("--history");
  if (!work.empty()) work.insert(work.end(), others.begin(), others.end());
  if (work.size() > 1) throw Error(fmt::format("{}: cannot be combined; expected one of them at a time", fmt::join(work, ", ")));
  const bool imports = std::find(others.begin(), others.end(), "--import") != others.end();
  if (!arguments.edits.empty() || imports) return;
  for (const auto& [option, is_given] : {std::pair{"--who", !arguments.who.empty()}, std::pair{"--why", !arguments.why.empty()},
                                         std::pair{"--dry-run", arguments.dry_run}}) {
    if (is_given) throw Error(fmt::format("{}: belongs to edits; expected an edit such as --confirm, or --import", option));
  }
}

void edit_labels(const CommonArguments& common, const LabelEditArguments& arguments, const std::vector<std::string>& places,
                 bool draw_pictures) {
  std::vector<RunEdits> runs;
  const labels::EditNote note = arguments.note();
  std::vector<RunAndLabels> edited;
  std::vector<std::size_t> made;
  // All are tried before the first is saved.
  for (RunEdits& run : edits_by_run(arguments.edits, places)) {
    std::size_t count = 0;
    labels::Labels now = labels::read_versioned_labels(run.run).labels;
    now = with_all(std::move(now), run, labels::span_of_events(run.run), note, count);
    if (count == 0) continue;
    edited.push_back({run.run, std::move(now)});
    made.push_back(count);
    runs.push_back(std::move(run));
  }
  if (runs.empty())
    refuse(arguments.edits.front(),
           "there is nothing to edit in the runs that match; expected such an interval or flag, not confirmed yet");
  for (std::size_t i = 0; i < runs.size() && !arguments.dry_run; ++i) {
    const auto change = [&](labels::Labels now, const labels::RecordingSpan& recording) {
      return with_all(std::move(now), runs[i], recording, note, made[i]);
    };
    edited[i].labels = std::get<labels::VersionedLabels>(labels::save_change(runs[i].run, std::nullopt, change)).labels;
  }
  Printed printed;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const std::vector<labels::HistoryEntry>& entries = edited[i].labels.history.entries;
    for (std::size_t k = entries.size() - made[i]; k < entries.size(); ++k)
      printed.add(runs[i].run, entries[k], arguments.dry_run ? "would be: " : "");
  }
  if (draw_pictures && !arguments.dry_run) draw_label_pictures(edited, common.threads);
  print_result(common, {{"edited", printed.json}, {"dry_run", arguments.dry_run}}, printed.text);
}

void go_through_history(const CommonArguments& common, const LabelEditArguments& arguments, const RunsBelow& found,
                        bool draw_pictures) {
  if (arguments.history) return print_history(common, found);
  const bool is_undo = !arguments.undo.empty();
  const char* const option = is_undo ? "--undo" : "--redo";
  const std::size_t count = count_in(option, is_undo ? arguments.undo : arguments.redo);
  if (found.runs.size() != 1) {
    throw Error(fmt::format("{}: {} runs are given; expected one, as in 'tactile label data/fan/01 {}'", option,
                            found.runs.size(), option));
  }
  undo_or_redo(common, is_undo, count, found.runs.front(), draw_pictures);
}

}  // namespace tactile::cli
