#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "tactile/core/run_folder.hpp"
#include "tactile/core/time.hpp"
#include "tactile/splitting/split_proposal.hpp"

namespace tactile::review {

/// Where a person cuts a long recording into runs: proposes cuts, and writes the runs of the cuts that the person chose. One
/// recording at a time; the work is done on a thread of its own. All functions may be called from several threads.
class SplitDesk {
 public:
  /// @param out  folder of runs, where the pieces are written
  explicit SplitDesk(std::filesystem::path out) : out_(std::move(out)) {}
  ~SplitDesk();  ///< ends the work; a run is written whole or not at all

  /// The state of the desk for this run, after the work on it has begun. Another run, or another `quiet`, begins a new proposal;
  /// while runs are being written, it is refused. Times are microseconds after the recording's first event.
  ///
  ///   {"state": "proposing" | "proposed" | "cutting" | "cut" | "failed", "share": 0 to 1, "error": sentence or null,
  ///    "quiet_s", "out", "object", "length_us", "cuts_us": [], "touches": [{"kind", "begin_us", "end_us"}],
  ///    "result": null or that of `tactile split --json`}
  ///
  /// @throws Refusal  (409) if another recording is being cut
  nlohmann::json look(const RunFolder& run, microseconds quiet);

  /// Begins to write the runs.
  /// @param cuts     after the first event, ascending
  /// @param objects  one for all runs, or one for each
  /// @throws Refusal  (409) unless a proposal of this run is there; (400) if the cuts do not suit
  nlohmann::json cut(const RunFolder& run, const std::vector<microseconds>& cuts, const std::vector<std::string>& objects);

 private:
  enum class State : std::uint8_t { proposing, proposed, cutting, cut, failed };

  void begin_proposal(const RunFolder& run, microseconds quiet);
  void end_work();
  void advance(std::uint64_t done, std::uint64_t total);
  void set(State state, const std::string& error = {});
  nlohmann::json json() const;

  std::filesystem::path out_;
  std::mutex asking_;  ///< one request at a time
  std::thread work_;
  std::atomic<bool> ends_{false};

  mutable std::mutex guard_;  ///< of all that follows
  std::string name_;          ///< of the run on the desk; empty: none
  RunFolder run_;
  microseconds quiet_{};
  State state_ = State::proposing;
  double share_ = 0;
  std::string error_, object_;
  std::optional<splitting::SplitProposal> proposal_;
  nlohmann::json result_;
};

}  // namespace tactile::review
