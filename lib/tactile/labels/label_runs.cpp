#include "tactile/labels/label_runs.hpp"

#include <algorithm>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/error_text.hpp"
#include "tactile/core/folder_lock.hpp"
#include "tactile/core/json_text.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/labels/label_history.hpp"
#include "tactile/labels/saved_labels.hpp"
#include "tactile/labels/session_name.hpp"

namespace tactile::labels {
namespace {

namespace fs = std::filesystem;

/// Increases with every change that gives the same files other labels.
constexpr int method_version = 13;

/// Runs that are labelled together because they share their clocks: those of a session, or one alone.
struct Group {
  std::vector<RunFolder> runs;            ///< by name; the requested ones and the rest of their session
  std::vector<std::size_t> requested;     ///< indices into `runs`
  std::vector<std::size_t> result_index;  ///< of each requested one
};

/// The session that run.json names, or the camera's start, which the recordings of a session share.
std::optional<std::string> session_of(const RunFolder& run) {
  try {
    if (const std::string session = read_run_info(run).session; !session.empty()) return session;
    return camera_session_of(events::event_stream(events::RecordingReader(run.events())));
  } catch (const std::exception&) {  // the error appears when the run is read
  }
  return std::nullopt;
}

fs::path data_folder_of(const RunFolder& run) {
  std::error_code unknown;
  const fs::path folder = fs::weakly_canonical(run.folder, unknown);
  return (unknown ? fs::absolute(run.folder).lexically_normal() : folder).parent_path().parent_path();
}

/// By data folder and session, all runs of it.
class Sessions {
 public:
  const std::vector<RunFolder>& runs_of(const fs::path& data, const std::string& session) {
    if (read_.insert(data).second) {
      for (const RunFolder& run : find_runs(data)) {
        if (const auto name = session_of(run)) runs_[{data, *name}].push_back(run);
      }
    }
    return runs_[{data, session}];
  }

 private:
  std::set<fs::path> read_;
  std::map<std::pair<fs::path, std::string>, std::vector<RunFolder>> runs_;
};

std::vector<Group> groups_of(const std::vector<RunFolder>& runs) {
  Sessions sessions;
  std::map<std::pair<fs::path, std::string>, std::size_t> group_of_session;
  std::vector<Group> groups;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const std::optional<std::string> session = session_of(runs[i]);
    Group* group = nullptr;
    if (session) {
      const fs::path data = data_folder_of(runs[i]);
      const auto [found, is_new] = group_of_session.try_emplace({data, *session}, groups.size());
      if (is_new) groups.push_back({.runs = sessions.runs_of(data, *session), .requested = {}, .result_index = {}});
      group = &groups[found->second];
    } else {
      group = &groups.emplace_back();
    }
    const auto same = [&](const RunFolder& run) {
      std::error_code unknown;
      return fs::equivalent(run.folder, runs[i].folder, unknown);
    };
    const auto place = std::find_if(group->runs.begin(), group->runs.end(), same);
    group->requested.push_back(static_cast<std::size_t>(place - group->runs.begin()));
    group->result_index.push_back(i);
    if (place == group->runs.end()) group->runs.push_back(runs[i]);
  }
  return groups;
}

/// A hash of all that the labels of the group's runs depend on.
std::string key_of(const Group& group, const std::vector<nlohmann::json>& inputs, const RunFolder& run,
                   const LabelOptions& options) {
  nlohmann::json made_from = {{"method", method_version}, {"settings", settings_of(options)}, {"run", run.name()}};
  for (std::size_t i = 0; i < group.runs.size(); ++i) made_from["inputs"][group.runs[i].name()] = inputs[i];
  return sha256_of(json_text(made_from));
}

/// The signals of a run, or why they could not be read.
struct ReadRun {
  std::optional<alignment::RunSignals> signals;
  std::string error;
};

class GroupLabeller {
 public:
  using Done = std::function<void(const RunFolder&)>;

  explicit GroupLabeller(const LabelRunsOptions& options) : options_(options) {}

  /// Sets the results of the requested runs.
  void label(const Group& group, std::vector<RunOutcome>& results, const Done& done) const {
    const std::vector<nlohmann::json> inputs = input_hashes(group, results);
    std::vector<std::size_t> to_label;  // places in `requested`
    for (std::size_t k = 0; k < group.requested.size(); ++k) {
      const RunFolder& run = group.runs[group.requested[k]];
      RunOutcome& result = results[group.result_index[k]];
      if (result.error.empty()) take_existing(run, key_of(group, inputs, run, options_.label), result);
      if (result.error.empty() && !result.unchanged) {
        to_label.push_back(k);
      } else {
        done(run);
      }
    }
    if (to_label.empty()) return;

    const std::vector<ReadRun> read = read_all(group);
    std::vector<const alignment::RunSignals*> readable;
    for (const ReadRun& run : read) {
      if (run.signals) readable.push_back(&*run.signals);
    }
    const std::vector<RunPosterior> posteriors = session_posteriors(readable, options_.threads);
    parallel_for(to_label.size(), options_.threads, [&](std::size_t n) {
      const std::size_t i = group.requested[to_label[n]];
      RunOutcome& result = results[group.result_index[to_label[n]]];
      try {
        if (!read[i].signals) throw Error(read[i].error);
        const alignment::RunSignals& signals = *read[i].signals;
        const auto place = static_cast<std::size_t>(std::find(readable.begin(), readable.end(), &signals) - readable.begin());
        if (posteriors[place].failure) std::rethrow_exception(posteriors[place].failure);
        Labels labels = label_signals(signals, posteriors[place], options_.label);
        labels.provenance["inputs"] = inputs[i];
        labels.provenance["key"] = key_of(group, inputs, signals.run, options_.label);
        labels = write_over(signals.run, std::move(labels));
        if (options_.make_companions) options_.make_companions(signals, labels);
        result.labels = std::move(labels);
      } catch (const std::exception& e) {
        result.error = sentence_of(e, result.run.name());
      }
      done(result.run);
    });
  }

 private:
  /// Of all runs. Sets run and error of the requested ones' results.
  std::vector<nlohmann::json> input_hashes(const Group& group, std::vector<RunOutcome>& results) const {
    std::vector<nlohmann::json> inputs(group.runs.size());
    std::vector<std::string> errors(group.runs.size());
    parallel_for(group.runs.size(), options_.threads, [&](std::size_t i) {
      try {
        inputs[i] = alignment::hashes_of_inputs(group.runs[i]);
      } catch (const std::exception& e) {
        errors[i] = sentence_of(e, group.runs[i].name());
      }
    });
    for (std::size_t k = 0; k < group.requested.size(); ++k) {
      results[group.result_index[k]].run = group.runs[group.requested[k]];
      results[group.result_index[k]].error = errors[group.requested[k]];
    }
    return inputs;
  }

  /// Writes the labels, with a person's edits of the file as it is now: one may have been saved in the meantime.
  Labels write_over(const RunFolder& run, Labels fresh) const {
    const FolderLock lock(run.folder);
    std::optional<Labels> old;
    try {
      if (is_there(run.labels())) old = read_labels(run.labels());
    } catch (const Error&) {
      if (!options_.force) throw;
    }
    if (old && !options_.force) fresh = relabelled(fresh, *old);
    if (old && options_.force) fresh = relabelled_without_edits(std::move(fresh), *old, {.who = system_user(), .why = ""});
    write_labels(run.labels(), fresh);
    return fresh;
  }

  std::vector<ReadRun> read_all(const Group& group) const {
    std::vector<ReadRun> read(group.runs.size());
    parallel_for(group.runs.size(), options_.threads, [&](std::size_t i) {
      try {
        read[i].signals = alignment::read_run_signals(group.runs[i], options_.label.signals);
      } catch (const std::exception& e) {
        read[i].error = sentence_of(e, group.runs[i].name());
      }
    });
    return read;
  }

  /// Takes the labels of the file, if they follow from the same files and settings.
  void take_existing(const RunFolder& run, const std::string& key, RunOutcome& result) const {
    if (options_.force || !is_there(run.labels())) return;
    if (options_.has_companions && !options_.has_companions(run)) return;
    try {
      Labels labels = read_labels(run.labels());
      const auto made_from = labels.provenance.find("key");
      if (made_from == labels.provenance.end() || *made_from != key) return;
      result.labels = std::move(labels);
      result.unchanged = true;
    } catch (const std::exception& e) {
      result.error = sentence_of(e, run.name()) + "; repair it, or replace it with --force";
    }
  }

  const LabelRunsOptions& options_;
};

}  // namespace

std::vector<RunOutcome> label_runs(const std::vector<RunFolder>& runs, const LabelRunsOptions& options,
                                   const ProgressCallback& progress) {
  std::vector<RunOutcome> results(runs.size());
  std::vector<Group> groups = groups_of(runs);
  // The largest first, so that no thread is left with it alone at the end.
  std::stable_sort(groups.begin(), groups.end(), [](const Group& a, const Group& b) { return a.runs.size() > b.runs.size(); });

  const GroupLabeller labeller(options);
  std::mutex guard;
  std::size_t done = 0;
  parallel_for(groups.size(), options.threads, [&](std::size_t i) {
    labeller.label(groups[i], results, [&](const RunFolder& run) {
      const std::scoped_lock lock(guard);
      report_progress(progress, ++done, runs.size(), run.name());
    });
  });
  return results;
}

}  // namespace tactile::labels
