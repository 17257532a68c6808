#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tactile/results/accuracy.hpp"
#include "tactile/results/claim.hpp"
#include "tactile/results/members.hpp"
#include "tactile/results/step_record.hpp"
#include "tactile/results/unseen_comparison.hpp"
#include "tactile/results/whole_runs.hpp"

namespace tactile::results {

/// A run, or one interval of it, that is in no sample.
struct LeftOut {
  std::string run{};     ///< "fan/03"
  std::string what{};    ///< "run", or an interval's id: "press-1"
  std::string reason{};  ///< in words
};

template <class Members>
void list_members(Members& members, LeftOut& one) {
  members("run", one.run);
  members("what", one.what);
  members("reason", one.reason);
}

/// Runs that share their objects and their sensor: a simulated world, or a lab's own data.
struct StudyWorld {
  std::string name{};                   ///< the seed of a simulated world; empty for a lab's own data
  std::string data{}, manifest_hash{};  ///< folder of its runs; hash of its dataset
  std::uint64_t runs = 0, samples = 0;  ///< with samples, and those
  std::vector<std::string> held_out{};  ///< objects that are held out of training
  std::vector<LeftOut> left_out{};
};

template <class Members>
void list_members(Members& members, StudyWorld& world) {
  members("name", world.name);
  members("data", world.data);
  members("manifest_hash", world.manifest_hash);
  members("runs", world.runs);
  members("samples", world.samples);
  members("held_out", world.held_out);
  members("left_out", world.left_out);
}

/// A model that the study trained and judged.
struct StudiedModel {
  std::size_t world = 0, training = 0;  ///< which of `Study::worlds`, and of its trainings
  std::string setting{};                ///< "th040", "stream", "stream-unseen": as in the table of cells
  std::string name{}, folder{};         ///< of the bundle
  std::string history{};                ///< its loss over time, a CSV
  std::string train_run{};              ///< id of each object's training run
  std::uint64_t seed = 0;
  std::string weights_sha256{};
};

template <class Members>
void list_members(Members& members, StudiedModel& model) {
  members("world", model.world);
  members("training", model.training);
  members("setting", model.setting);
  members("name", model.name);
  members("folder", model.folder);
  members("history", model.history);
  members("train_run", model.train_run);
  members("seed", model.seed);
  members("weights_sha256", model.weights_sha256);
}

/// What a setting gives over all worlds and trainings.
struct StudiedSetting {
  std::string setting{};                                         ///< "th040", "stream-unseen"
  std::string text{};                                            ///< "LeNet, t_h 40 ms", "stream, objects never seen"
  bool is_unseen = false;                                        ///< on objects that were held out of training
  double history_ms = std::numeric_limits<double>::quiet_NaN();  ///< t_h; NaN of a stream
  Accuracy accuracy{};                                           ///< of balanced samples
  WholeRuns whole_runs{};                                        ///< without runs where only samples were judged
  std::map<std::string, Baseline> baselines{};                   ///< by name; those of a stream
};

template <class Members>
void list_members(Members& members, StudiedSetting& setting) {
  members("setting", setting.setting);
  members("text", setting.text);
  members("is_unseen", setting.is_unseen);
  members("th_ms", setting.history_ms);
  members("accuracy", setting.accuracy);
  members("whole_runs", setting.whole_runs);
  members("baselines", setting.baselines);
}

/// A setting on the same runs with their objects in training, and without.
struct StudiedUnseen {
  std::string setting{}, text{};
  UnseenComparison accuracy{};
};

template <class Members>
void list_members(Members& members, StudiedUnseen& unseen) {
  members("setting", unseen.setting);
  members("text", unseen.text);
  members("accuracy", unseen.accuracy);
}

/// A run over time, as a CSV of `tactile eval --run`.
struct ReportedRun {
  std::string run{}, model{};
  double history_ms = std::numeric_limits<double>::quiet_NaN();  ///< time that a tick counts events of
  std::string csv{};                                             ///< how its intervals were detected lies next to it, as .json
};

template <class Members>
void list_members(Members& members, ReportedRun& run) {
  members("run", run.run);
  members("model", run.model);
  members("th_ms", run.history_ms);
  members("csv", run.csv);
}

/// The paper's study, in several worlds. Paths are relative to its folder.
struct Study {
  static constexpr const char* command = "tactile reproduce";

  std::string format = "tactile-study-2";
  std::string title{};
  bool simulated = false;
  nlohmann::json settings = nlohmann::json::object(), software = nullptr, machine = nullptr;
  BootstrapOptions bootstrap{};
  std::string intervals{};  ///< a sentence: what they are over
  std::vector<StepRecord> steps{};
  std::vector<StudyWorld> worlds{};
  std::vector<StudiedModel> models{};
  std::string cells{};                    ///< the table that every figure is made from, a CSV
  std::vector<StudiedSetting> results{};  ///< histories ascending, then streams; those of unseen objects last
  std::vector<StudiedUnseen> unseen{};
  std::vector<ReportedRun> full_runs{};
  std::vector<Claim> claims{};
  std::vector<std::string> found{};  ///< sentences
  std::vector<std::string> remarks{};

  const StudiedSetting* find(const std::string& setting) const;  ///< null if it has no such result
};

template <class Members>
void list_members(Members& members, Study& study) {
  members("format", study.format);
  members("title", study.title);
  members("simulated", study.simulated);
  members("settings", study.settings);
  members("software", study.software);
  members("machine", study.machine);
  members("bootstrap", study.bootstrap);
  members("intervals", study.intervals);
  members("steps", study.steps);
  members("worlds", study.worlds);
  members("models", study.models);
  members("cells", study.cells);
  members("results", study.results);
  members("unseen", study.unseen);
  members("full_runs", study.full_runs);
  members("claims", study.claims);
  members("found", study.found);
  members("remarks", study.remarks);
}

/// study.json of a folder. @throws Error  if it cannot be read, is of another format, or has a model of a world that is not there
Study read_study(const std::filesystem::path& folder);

}  // namespace tactile::results
