#include "tactile/windows/dataset_plan.hpp"

#include <algorithm>
#include <map>
#include <mutex>
#include <new>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/error_text.hpp"
#include "tactile/core/folders_in.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/core/random.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/text_lines.hpp"
#include "tactile/core/ticks.hpp"
#include "tactile/events/event_digest.hpp"
#include "tactile/events/simulated_recording.hpp"
#include "tactile/labels/labels.hpp"
#include "tactile/windows/dataset_layout.hpp"
#include "tactile/windows/dataset_settings.hpp"

namespace tactile::windows {
namespace fs = std::filesystem;

namespace {

/// @return  the sensor's size. @throws Error  if run.json has another one
events::SensorSize sensor_of(const OpenRun& open, const PlannedRun& run) {
  const events::SensorSize declared{run.info.width, run.info.height};  // no area without run.json
  const events::SensorSize sensor = open.recording.stream(open.stream_id).size.value_or(declared);
  if (declared.width > 0 && sensor != declared) {
    throw Error(run.folder.events().string() + ": of a sensor of " + std::to_string(sensor.width) + "x" +
                std::to_string(sensor.height) + " px; expected the " + std::to_string(declared.width) + "x" +
                std::to_string(declared.height) + " px in run.json");
  }
  return sensor;
}

/// Takes what the older dataset knows of the same recording. @return  false if it has not read it
bool take_facts(PlannedRun& run, const OlderDataset* older) {
  const auto facts = older == nullptr ? std::nullopt : older->facts_of(run.events_sha256);
  if (!facts) return false;
  run.first_event = facts->first;
  run.last_event = facts->last;
  run.event_digest = facts->digest;
  run.sensor = events::SensorSize{run.info.width, run.info.height};
  if (run.sensor != older->sensor()) run.sensor = sensor_of(OpenRun(run.folder), run);
  return true;
}

void find_facts(PlannedRun& run) {
  run.was_read = true;
  OpenRun open(run.folder);
  const std::string where = run.folder.events().string();
  run.sensor = sensor_of(open, run);
  std::optional<CameraTime> last;
  events::EventDigest digest;
  events::for_all_events(open.recording, open.stream_id, [&](std::span<const events::Event> events) {
    for (const events::Event& event : events) {
      if (!last) run.first_event = event.t;
      if (last && event.t < *last) {
        throw Error(where + ": events go back in time at " + std::to_string(us_of(event.t)) +
                    " us; expected them in ascending order, as 'tactile repair' puts them");
      }
      last = event.t;
    }
    run.recorded_events += events.size();
    digest.add(events);
  });
  if (!last) throw Error(where + ": has no event; expected a recording of the run");
  run.last_event = *last;
  run.event_digest = digest.text();
}

std::string list_of(const std::vector<std::string>& names, std::string_view between_them = ", ") {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : std::string(between_them)) + name;
  return text;
}

/// Draws the run's samples. @return  why it has none; nothing if it has some
std::optional<NoSamples> draw_samples(PlannedRun& run, const labels::Labels& labels, const WindowsOptions& options) {
  std::vector<SampledInterval> intervals;
  std::vector<std::string> flagged;
  for (std::size_t i = 0; i < labels.intervals.size(); ++i) {
    const bool used = options.include_flagged || !labels.interval_is_flagged(i);
    intervals.push_back({labels.intervals[i].interval(), used});
    if (used) run.intervals.push_back(labels.intervals[i].interval());
    if (!used) flagged.push_back(labels.intervals[i].id);
  }
  const std::uint64_t seed = seed_for(options.sampling.seed, {"windows", run.folder.object, run.folder.run});
  run.samples =
      balanced_samples(0, intervals, run.first_event, run.last_event, seed, options.sampling, labels::unclear_motion(labels));
  for (const Sample& sample : run.samples) ++run.outcome.samples[static_cast<std::size_t>(sample.touch)];

  if (!run.samples.empty()) {
    if (!flagged.empty()) run.outcome.remark = "flagged and left out: " + list_of(flagged);
    return std::nullopt;
  }
  std::optional<NoSamples> reason = why_no_samples(labels, options.include_flagged);
  if (!reason) {
    const auto offered =
        ticks_on_offer(intervals, run.first_event, run.last_event, options.sampling, labels::unclear_motion(labels));
    std::vector<std::string> lacking;
    for (const Touch touch : all_touches) {
      if (offered[static_cast<std::size_t>(touch)] == 0) lacking.emplace_back(name_of(touch));
    }
    reason = has_no("ticks of " + list_of(lacking, " and "));
  }
  run.outcome.remark = "no samples: " + reason->words + (reason->flags.empty() ? "" : " (" + reason->flags + ")");
  return reason;
}

/// All reasons so far why runs are left out.
std::string all_reasons(const DatasetPlan& plan) {
  std::vector<std::string> reasons = plan.warnings;
  reasons.insert(reasons.end(), plan.errors.begin(), plan.errors.end());
  return list_of(reasons, "; ");
}

void leave_out(DatasetPlan& plan, const PlannedRun& run, std::string why) {
  plan.left_out.push_back(run.outcome);
  plan.left_out.back().remark = std::move(why);
}

void add_without_samples(DatasetPlan& plan, const PlannedRun& run, NoSamples reason) {
  plan.without_samples.push_back({run.folder.object, run.folder.run, std::move(reason)});
}

/// The run.json of a run; without one, the information from its folder.
RunInfo info_of(const RunFolder& folder) {
  RunInfo info;
  if (is_there(folder.info())) {
    info = read_run_info(folder);
    info.extra.clear();  // which is large, and the plan holds all runs
  } else {
    info.object = folder.object;
    info.run = folder.run;
    info.complete = true;
  }
  info.simulated = events::is_simulated(folder);
  return info;
}

/// Warns of irregular runs that are used nevertheless.
void warn_of_oddities(const std::vector<PlannedRun>& runs, std::vector<std::string>& warnings) {
  std::vector<std::string> without_info;
  for (const PlannedRun& run : runs) {
    const std::string name = run.folder.name();
    if (!is_there(run.folder.info())) without_info.push_back(name);
    if (!run.info.complete)
      warnings.push_back(name + ": run.json has complete = false, the recording was not closed; its events are used");
    if (run.info.object != run.folder.object || run.info.run != run.folder.run)
      warnings.push_back(name + ": run.json names it " + run.info.object + "/" + run.info.run +
                         "; the name of its folder is used");
  }
  if (!without_info.empty())
    warnings.push_back(
        "runs without run.json (their names come from the folders, the sensor from the recording; they are simulated if they "
        "have truth.json, or if their camera is the simulator's): " +
        list_of(without_info));
}

bool holds_runs_of_an_object(const fs::path& folder) {
  const std::vector<fs::path> inside = folders_in(folder);
  return std::any_of(inside.begin(), inside.end(),
                     [](const fs::path& run) { return is_run_id(run.filename().string()) && is_there(run / "events.aedat4"); });
}

/// The runs below `data` whose run.json can be read. The plan lists the others. @throws Error  if there is none of either
std::vector<PlannedRun> readable_runs(const fs::path& data, DatasetPlan& plan) {
  std::vector<PlannedRun> found;
  RunsBelow below = look_for_runs(data);
  plan.misnamed = std::move(below.misnamed);
  plan.warnings = plan.misnamed;
  if (std::string missing = sentence_on_missing_recordings(below.without_recording); !missing.empty())
    plan.warnings.push_back(std::move(missing));
  plan.errors = std::move(below.unreadable);
  for (RunFolder& folder : below.runs) {
    PlannedRun run{.folder = std::move(folder),
                   .info = {},
                   .outcome = {},
                   .events_sha256 = {},
                   .labels_sha256 = {},
                   .sensor = {},
                   .event_digest = {},
                   .intervals = {},
                   .samples = {}};
    run.outcome.object = run.folder.object;
    run.outcome.run = run.folder.run;
    try {
      run.info = info_of(run.folder);
    } catch (const std::exception& e) {
      plan.errors.push_back(sentence_of(e) + "; " + run.folder.name() + " is left out");
      leave_out(plan, run, "its run.json cannot be read");
      add_without_samples(plan, run, has_no("readable run.json"));
      continue;
    }
    found.push_back(std::move(run));
  }
  if (found.empty() && plan.left_out.empty() && plan.warnings.empty() && plan.errors.empty())
    throw Error(
        data.string() +
        (holds_runs_of_an_object(data)
             ? ": is the folder of one object's runs; expected the folder above it, DATA"
             : ": no runs; expected DATA/<object>/<run>/events.aedat4: 'tactile import' makes such folders of recordings"));
  return found;
}

/// The labelled runs below `data` that may be used together. The plan lists the others.
std::vector<PlannedRun> choose_runs(const fs::path& data, const WindowsOptions& options, DatasetPlan& plan) {
  std::vector<PlannedRun> found = readable_runs(data, plan);
  const bool any_real = std::any_of(found.begin(), found.end(), [](const PlannedRun& run) { return !run.info.simulated; });
  std::vector<std::string> unlabelled, simulated;
  std::vector<PlannedRun> chosen;
  for (PlannedRun& run : found) {
    if (any_real && run.info.simulated && !options.mix) {
      leave_out(plan, run, "simulated, and there are real runs");
      ++plan.passed_over;
      simulated.push_back(run.folder.name());
    } else if (!is_there(run.folder.labels())) {
      leave_out(plan, run, "no labels.json");
      add_without_samples(plan, run, has_no("labels"));
      unlabelled.push_back(run.folder.name());
    } else {
      chosen.push_back(std::move(run));
    }
  }
  if (!simulated.empty())
    plan.warnings.push_back("simulated runs are left out because there are real ones (--mix uses both): " + list_of(simulated));
  if (found.empty()) throw Error(data.string() + ": no run can be used (" + all_reasons(plan) + ")");
  if (chosen.empty()) {
    throw Error(data.string() + ": none of its " + std::to_string(unlabelled.size()) +
                (any_real && !simulated.empty() ? " real" : "") +
                " runs has labels; expected labels.json in each, run 'tactile label " + shell_word(data.string()) + "'");
  }
  if (!unlabelled.empty())
    plan.warnings.push_back("runs without labels are left out ('tactile label' makes them): " + list_of(unlabelled));
  warn_of_oddities(chosen, plan.warnings);
  return chosen;
}

/// The most common sensor size; the first one if there are several.
events::SensorSize common_sensor(const std::vector<PlannedRun>& runs) {
  const auto runs_of = [&](events::SensorSize size) {
    return std::count_if(runs.begin(), runs.end(), [&](const PlannedRun& run) { return run.sensor == size; });
  };
  const events::SensorSize common = std::max_element(runs.begin(), runs.end(), [&](const PlannedRun& a, const PlannedRun& b) {
                                      return runs_of(a.sensor) < runs_of(b.sensor);
                                    })->sensor;
  for (const PlannedRun& run : runs) {
    if (run.sensor != common) {
      throw Error(run.folder.name() + ": of a sensor of " + std::to_string(run.sensor.width) + "x" +
                  std::to_string(run.sensor.height) + " px; expected the " + std::to_string(common.width) + "x" +
                  std::to_string(common.height) + " px of the other runs");
    }
  }
  return common;
}

/// A run's folder as stored: relative to the dataset's folder if it lies below that, otherwise absolute.
std::string folder_name(const RunFolder& run, const fs::path& dataset) {
  const fs::path folder = fs::weakly_canonical(run.folder), base = fs::weakly_canonical(fs::absolute(dataset).parent_path());
  const fs::path relative = folder.lexically_relative(base);
  const bool below = !relative.empty() && *relative.begin() != "..";
  return (below ? relative : folder).string();
}

/// Warns of the runs without samples, of the objects that have no other runs, and says how to lift flags.
/// @throws Error  if no run has samples, or `strict` and an object has none
void warn_of_runs_without_samples(DatasetPlan& plan, const fs::path& data, const std::set<std::string>& with_samples,
                                  bool strict) {
  std::vector<RunWithoutSamples>& none = plan.without_samples;
  if (none.empty()) return;
  std::sort(none.begin(), none.end(), [](const RunWithoutSamples& a, const RunWithoutSamples& b) {
    return std::tie(a.object, a.run) < std::tie(b.object, b.run);
  });
  const std::string sentence =
      sentence_on(none, plan.runs.size() + plan.left_out.size() - plan.passed_over, data, "tactile windows");
  if (with_samples.empty()) {
    throw Error(data.string() + ": expected a run with press and slip that are not flagged; " + sentence +
                (plan.warnings.empty() && plan.errors.empty() ? "" : " " + all_reasons(plan)));
  }
  const std::vector<std::string> objects = objects_left_out(none, with_samples);
  if (strict) refuse_objects_left_out(objects);
  plan.warnings.push_back(sentence);
  plan.warnings.insert(plan.warnings.end(), objects.begin(), objects.end());
}

/// Whether the labels belong to these events; true if they name no events, such as labels that a person wrote.
bool made_from(const labels::Labels& labels, const std::string& events_sha256) {
  const nlohmann::json inputs =
      labels.provenance.is_object() ? labels.provenance.value("inputs", nlohmann::json::object()) : nlohmann::json::object();
  return !inputs.is_object() || !inputs.contains("events.aedat4") || inputs.at("events.aedat4") == events_sha256;
}

struct RunOutcome {
  std::string why_left_out;  ///< empty if the run is in the dataset
  std::string error;         ///< why it cannot be read; empty if it can
  std::optional<NoSamples> why_no_samples;
};

/// Reads a run's labels and events, and draws its samples.
RunOutcome plan_run(PlannedRun& run, const WindowsOptions& options, const OlderDataset* older) {
  const labels::Labels labels = labels::read_labels(run.folder.labels());
  if (labels.run_is_flagged() && !options.include_flagged) {
    const std::optional<NoSamples> why = why_no_samples(labels, options.include_flagged);
    return {.why_left_out = "flagged: " + why->flags, .error = {}, .why_no_samples = why};
  }
  run.events_sha256 = sha256_of_file(run.folder.events());
  if (!made_from(labels, run.events_sha256)) {
    return {.why_left_out = "its events have changed since it was labelled, run 'tactile label' again",
            .error = {},
            .why_no_samples = has_no("labels of its present events")};
  }
  // A dataset of version 0.1 has the hash of the file: it stays the same while the file does.
  const DatasetRun* before = older == nullptr ? nullptr : older->run_of(run.folder, run.events_sha256);
  const bool is_of_file = before != nullptr && before->labels_sha256 == sha256_of_file(run.folder.labels());
  run.labels_sha256 = is_of_file ? before->labels_sha256 : labels::touches_sha256(labels);
  if (!take_facts(run, older)) find_facts(run);
  std::string why = why_too_many(full_ticks(run.first_event, run.last_event, options.sampling.history, options.sampling.tick));
  if (run.sensor.width <= 0) why = "neither its recording nor run.json has the sensor's size";
  if (!why.empty()) return {.why_left_out = why, .error = {}, .why_no_samples = has_no("recording that can be used")};
  return {.why_left_out = {}, .error = {}, .why_no_samples = draw_samples(run, labels, options)};
}

/// Adds a run to the dataset's runs, or to those left out.
void add_to_plan(DatasetPlan& plan, PlannedRun run, const RunOutcome& outcome) {
  if (run.was_read) plan.read_runs.push_back(run.folder.name());
  if (outcome.why_left_out.empty()) {
    plan.runs.push_back(std::move(run));
    return;
  }
  if (!outcome.error.empty()) {
    plan.errors.push_back(outcome.error + "; " + run.folder.name() + " is left out");
  } else if (!outcome.why_no_samples->flagged) {
    plan.warnings.push_back(run.folder.name() + ": left out, " + outcome.why_left_out);
  }
  leave_out(plan, run, outcome.why_left_out);
}

/// Numbers the runs, adds their rows, and warns of intervals that are left out and of recordings that occur twice.
void add_rows(DatasetPlan& plan, const fs::path& file) {
  std::map<std::string, std::string> run_with;
  bool says_how_to_lift = std::any_of(plan.without_samples.begin(), plan.without_samples.end(),
                                      [](const RunWithoutSamples& run) { return run.reason.flagged; });
  for (std::uint32_t index = 0; index < plan.runs.size(); ++index) {
    PlannedRun& run = plan.runs[index];
    for (Sample& sample : run.samples) sample.run_index = index;
    run.outcome.in_dataset = true;
    plan.simulated = plan.simulated || run.info.simulated;
    if (!run.samples.empty() && !run.outcome.remark.empty()) {
      plan.warnings.push_back(run.folder.name() + ": " + run.outcome.remark +
                              (says_how_to_lift ? "" : ". " + how_to_lift_flags(run.folder, "tactile windows")));
      says_how_to_lift = true;
    }
    const auto [other, is_new] = run_with.emplace(run.events_sha256, run.folder.name());
    if (!is_new)
      plan.warnings.push_back(run.folder.name() + ": has the same recording as " + other->second +
                              ", so a split may test on what it trained on");
    plan.rows.push_back({.object = run.folder.object,
                         .run = run.folder.run,
                         .folder = folder_name(run.folder, file),
                         .events_sha256 = run.events_sha256,
                         .labels_sha256 = run.labels_sha256,
                         .recording = RecordingFacts{run.first_event, run.last_event, run.event_digest}});
  }
}

}  // namespace

DatasetPlan plan_dataset(const fs::path& data, const fs::path& file, const WindowsOptions& options, unsigned threads,
                         const ProgressCallback& progress, const OlderDataset* older) {
  check(options.sampling);
  DatasetPlan plan;
  std::vector<PlannedRun> chosen = choose_runs(data, options, plan);
  std::vector<RunOutcome> outcomes(chosen.size());
  std::mutex guard;
  std::uint64_t done = 0;
  parallel_for(chosen.size(), threads, [&](std::size_t i) {
    const std::string name = chosen[i].folder.name();
    try {
      outcomes[i] = plan_run(chosen[i], options, older);
    } catch (const std::bad_alloc&) {
      throw;  // no fault of the run: without it the dataset would be another on another machine
    } catch (const std::exception& e) {
      const std::string error = sentence_of(e, name);
      outcomes[i] = {.why_left_out = error, .error = error, .why_no_samples = has_no("files that can be read")};
    }
    const std::scoped_lock lock(guard);
    report_progress(progress, ++done, 2 * chosen.size(), name);
  });
  std::set<std::string> with_samples;  // objects
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    if (outcomes[i].why_no_samples) {
      add_without_samples(plan, chosen[i], *outcomes[i].why_no_samples);
    } else {
      with_samples.insert(chosen[i].folder.object);
    }
    add_to_plan(plan, std::move(chosen[i]), outcomes[i]);
  }
  warn_of_runs_without_samples(plan, data, with_samples, options.strict);
  plan.sensor = common_sensor(plan.runs);
  add_rows(plan, file);
  plan.settings = dataset_settings_of(options);
  plan.manifest = dataset_layout::manifest_of(plan.settings, plan.sensor, plan.simulated, plan.rows);
  return plan;
}

std::vector<TimeSpan> histories_of(std::span<const Sample> samples, microseconds history) {
  std::vector<TimeSpan> histories;
  for (const Sample& sample : samples) {
    const CameraTime begin = before(sample.t, history);
    if (!histories.empty() && begin <= histories.back().end) {
      histories.back().end = sample.t;
    } else {
      histories.push_back({begin, sample.t});
    }
  }
  return histories;
}

bool may_be_stored(const OpenRun& open, const events::PacketRecord& packet, std::span<const TimeSpan> histories) {
  return packet.stream_id == open.stream_id && packet.elements > 0 && !histories.empty() && packet.first < histories.back().end &&
         packet.last >= histories.front().begin;
}

void for_stored_events(OpenRun& open, std::span<const events::PacketRecord> packets, std::span<const TimeSpan> histories,
                       const std::function<void(std::span<const events::Event>)>& use) {
  auto history = histories.begin();
  std::vector<events::Event> stored;
  for (const events::PacketRecord& packet : packets) {
    if (!may_be_stored(open, packet, histories)) continue;
    stored.clear();
    for (const events::Event& event : open.recording.read_events(packet)) {
      while (history != histories.end() && history->end <= event.t) ++history;
      if (history != histories.end() && event.t >= history->begin) stored.push_back(event);
    }
    use(stored);
  }
}

}  // namespace tactile::windows
