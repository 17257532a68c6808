#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/events/cut_recording.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/splitting/split_proposal.hpp"
#include "tactile/splitting/split_source.hpp"

namespace tactile::splitting {

struct SplitOptions {
  std::filesystem::path data = "data";
  std::vector<std::string> objects{"unnamed"};  ///< one for all runs, or one for each
  std::optional<int> first_run{};               ///< 1 to 99; default: the number after the highest existing one
  std::string session{};                        ///< of all runs; empty: that of `session_of`
  microseconds margin{1'000'000};               ///< robot log and film of a run reach so far beyond its ends, >= 0
};

/// A run folder that was made, or that an earlier call had made of the same piece.
struct SplitRun {
  RunFolder run;
  bool is_kept = false;  ///< it exists already
  std::uint64_t events = 0, packets_copied = 0, packets_encoded = 0;
  std::optional<std::uint64_t> robot_rows, frames;  ///< nothing if there is none
  std::uint64_t bytes = 0;
};

struct SplitResult {
  std::vector<SplitRun> runs;  ///< in the order of time
  std::string session;         ///< of all runs
  std::string robot, film;     ///< how they were cut, or why each run has the whole; empty if there is none
  std::string warning;         ///< a sentence if the recording lies among the runs of DATA; else empty
  events::RecordingProblems problems;
};

/// Cuts a recording into run folders, DATA/<object>/<run>/: events and the other streams of the camera, robot log, film and
/// run.json with the hashes of all. The recording and its files are only read. Times stay those of the recording's clocks, and
/// all runs have the same session, so that `tactile label` takes their clocks for one.
///
/// - Robot log and film are cut with a margin if their clock is known (`proposal.robot`, `proposal.film`), and a run without rows
/// or
///   frames has no such file; else each run gets
///   the whole.
/// - Of several event streams, the runs have the proposal's, and the other streams of its camera.
/// - run.json is that of the recording, if it has one, with the pairs of host and camera time of the piece, and under `split` the
///   origin: the recording's name and SHA-256, and the piece's times.
/// - Runs take free numbers; no existing one is changed. Each appears complete, after all are written. A run that an earlier call
///   made of the same piece and the same files is kept.
/// @throws Error  before anything is written if an object's name is wrong, the numbers do not suffice, or DATA has runs of the
///                same recording with other cuts or files, which would hold the same events twice; or if a file cannot be read or
///                written
SplitResult split_recording(const SplitSource& source, events::RecordingReader& recording, const SplitProposal& proposal,
                            const SplitOptions& options, const ProgressCallback& progress = {});

nlohmann::json json_of(const SplitResult& result);

}  // namespace tactile::splitting
