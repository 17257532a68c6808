#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "tactile/core/runs_below.hpp"
#include "tactile/review/label_cache.hpp"
#include "tactile/review/run_events.hpp"

namespace tactile::review {

/// What only all events of a run show.
struct RunSurvey {
  double peak_per_s = 0;     ///< rate of the fullest 2 ms
  CameraTime busiest_end{};  ///< of the 40 ms with the most events
};

/// All runs, as a table. What their recordings hold is found on a thread, the smallest first; labels are always as they are now.
class RunList {
 public:
  using Find = std::function<RunsBelow()>;  ///< looks for the runs; may throw an `Error`

  /// @param find  called at once, and again at most every second, so that new runs appear
  /// @throws Error  what `find` throws at once, or if two runs have the same name
  RunList(Find find, std::shared_ptr<LabelCache> labels);
  ~RunList();

  /// {"data", "revision", "progress", "runs"}, as the page gets them.
  nlohmann::json table();

  /// The row of one run. @throws Refusal  (404) if there is no such run
  nlohmann::json row(const std::string& object, const std::string& run);

  /// @throws Refusal  (404) if there is no such run
  RunFolder find(const std::string& object, const std::string& run);

  /// @throws Error  if its recording cannot be read
  RunFacts facts(const RunFolder& run);

  /// Its events in false colours, 160 px wide at the most, as PNG: after the first press's onset, else the busiest 40 ms. Nothing
  /// while its events are not surveyed; empty if they cannot be shown.
  std::optional<std::string> thumbnail(const RunFolder& run);

 private:
  struct Known {
    std::string stamp;  ///< of the recording
    std::optional<RunFacts> facts{};
    std::optional<RunSurvey> survey{};
    std::string error{};  ///< why the recording cannot be read
    std::shared_ptr<const std::string> thumbnail{};
    std::string thumbnail_of{};
  };
  struct Row {
    RunFolder run;
    Known known;
  };

  void refresh();
  void survey_runs();
  std::optional<RunFolder> next_to_survey();
  void survey(const RunFolder& run);
  nlohmann::json json_of(const Row& row);
  Row row_of(const RunFolder& run);

  Find find_;
  std::shared_ptr<LabelCache> labels_;
  std::mutex guard_;
  RunsBelow found_;
  std::chrono::steady_clock::time_point looked_{};
  std::map<std::string, Known> known_;  ///< by name
  std::condition_variable changed_;
  std::atomic<bool> ends_{false};
  std::thread surveys_;
};

}  // namespace tactile::review
