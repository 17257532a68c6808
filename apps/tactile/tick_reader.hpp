#pragma once

#include <chrono>
#include <cstdint>
#include <fstream>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "live_line.hpp"
#include "tactile/detect/detection_session.hpp"

namespace tactile::cli {

struct TickReaderOptions {
  std::string csv;           ///< write every tick to this file; empty: none
  bool keeps = false;        ///< keep the ticks for a plot
  bool camera_time = false;  ///< print camera times instead of seconds since the first event
  bool prints = true;        ///< print a line to stdout when press or slip begins, and when it ends
};

/// Shows, writes and keeps the ticks of a detection.
class TickReader {
 public:
  /// @param line  must outlive this. @throws Error  if the CSV cannot be written; so do the functions of `output`
  TickReader(TickReaderOptions options, LiveLine& line);

  detect::TickOutput output();  ///< refers to this

  std::uint64_t not_kept() const { return not_kept_; }
  const std::vector<detect::ReportedTick>& kept() const { return kept_; }

 private:
  void check_file() const;
  void read(std::span<const detect::ReportedTick> ticks);
  void write(const detect::ReportedTick& tick);
  void begin_episode(const detect::ReportedTick& tick);
  void confirm(const detect::VerdictEpisode& episode);
  void end_episode(const detect::VerdictEpisode& episode);
  void end();
  void draw();

  const TickReaderOptions options_;
  LiveLine& line_;
  std::ofstream file_;
  std::vector<detect::ReportedTick> kept_;
  std::optional<detect::ReportedTick> newest_;
  CameraTime zero_{};  ///< of the times of the present episode
  std::uint64_t skipped_ = 0, not_kept_ = 0;
  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now(), drawn_{};
};

}  // namespace tactile::cli
