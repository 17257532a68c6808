#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tactile/results/figure.hpp"
#include "tactile/results/members.hpp"
#include "tactile/results/step_record.hpp"
#include "tactile/results/whole_runs.hpp"

namespace tactile::results {

/// All runs at one severity.
struct StressPoint {
  double severity = 0;
  Figure accuracy{};         ///< mean over objects, in [0, 1]
  Figure accuracy_change{};  ///< to the harmless severity, paired over trainings and runs; nothing at the harmless severity
  OperatingPoint whole{};    ///< delays and false alarms over whole runs
};

template <class Members>
void list_members(Members& members, StressPoint& point) {
  members("severity", point.severity);
  members("accuracy", point.accuracy);
  members("accuracy_change", point.accuracy_change);
  members("whole", point.whole);
}

/// The severity up to which the accuracy is at most `Stress::most_lost` below that of the harmless severity.
struct HoldsUpTo {
  Figure severity{};       ///< linear between severities; the last one if the accuracy never falls so far
  bool is_beyond = false;  ///< it never falls so far
};

template <class Members>
void list_members(Members& members, HoldsUpTo& holds) {
  members("severity", holds.severity);
  members("is_beyond", holds.is_beyond);
}

/// A model on runs that are worsened by one recipe, from the harmless severity on.
struct StressCurve {
  std::string name{};                 ///< of the recipe or of the simulated world
  bool is_world = false;              ///< the runs are simulated again, and judged by their truth; else their events are changed
  std::string unit{};                 ///< of the severity
  std::string meaning{};              ///< one sentence
  std::vector<StressPoint> points{};  ///< the harmless severity first
  std::optional<HoldsUpTo> holds{};   ///< nothing without accuracies
};

template <class Members>
void list_members(Members& members, StressCurve& curve) {
  members("name", curve.name);
  members("is_world", curve.is_world);
  members("unit", curve.unit);
  members("meaning", curve.meaning);
  members("points", curve.points);
  members("holds_up_to", curve.holds);
}

/// The trainings of one setting.
struct StressedModel {
  std::string name{};                    ///< of the first training
  std::vector<std::string> trainings{};  ///< names of models
  std::vector<std::string> runs{};       ///< judged by at least one of them: "fan/03"
  std::vector<StressCurve> curves{};     ///< on these runs
  std::vector<StressCurve> quiet{};      ///< on recordings without a touch: false alarms only
};

template <class Members>
void list_members(Members& members, StressedModel& model) {
  members("name", model.name);
  members("trainings", model.trainings);
  members("runs", model.runs);
  members("curves", model.curves);
  members("quiet", model.quiet);
}

/// Models on runs that are worsened more and more.
struct Stress {
  static constexpr const char* command = "tactile stress";

  std::string format = "tactile-stress-2";
  std::string title{};
  bool simulated = false;
  std::string judged_by{};                 ///< in sentences: by which labels, and what the intervals are over
  std::string manifest_hash{};             ///< of the dataset; empty without one
  std::vector<std::string> quiet_files{};  ///< recordings without a touch
  std::uint64_t seed = 1;                  ///< of the recipes
  double most_lost = 0.05;                 ///< of the accuracy, for `HoldsUpTo`
  std::string engine{};
  BootstrapOptions bootstrap{};
  std::vector<StressedModel> models{};
  nlohmann::json settings = nullptr, software = nullptr, machine = nullptr;  ///< as in trade.json
  std::vector<StepRecord> steps{};
};

template <class Members>
void list_members(Members& members, Stress& stress) {
  members("format", stress.format);
  members("title", stress.title);
  members("simulated", stress.simulated);
  members("judged_by", stress.judged_by);
  members("manifest_hash", stress.manifest_hash);
  members("quiet_files", stress.quiet_files);
  members("seed", stress.seed);
  members("most_lost", stress.most_lost);
  members("engine", stress.engine);
  members("bootstrap", stress.bootstrap);
  members("models", stress.models);
  members("settings", stress.settings);
  members("software", stress.software);
  members("machine", stress.machine);
  members("steps", stress.steps);
}

/// "up to 120 kev/s [90, 160]", "beyond 500 kev/s", "unknown"; "holds" or "does not hold" for a recipe that is only on or off
std::string words_of(const StressCurve& curve);

}  // namespace tactile::results
