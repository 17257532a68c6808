#pragma once

#include <chrono>
#include <cstdint>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "detect_report.hpp"
#include "live_line.hpp"
#include "tactile/detect/tick_log.hpp"

namespace tactile {

struct TickReaderOptions {
  std::string csv;     ///< every tick is written there; empty: nowhere
  bool keeps = false;  ///< the ticks, to be drawn
  bool prints = true;  ///< a line to stdout where press or slip begins
};

/// What is shown, written, kept and summed up of the ticks, on a thread that may take its time.
class TickReader {
 public:
  /// @param line, summary  must outlive this. @throws Error  if the CSV cannot be written, as `read` and `end`
  TickReader(TickReaderOptions options, LiveLine& line, DetectSummary& summary);

  void read(TickLog& log);  ///< all that came since
  void end();

  std::uint64_t not_kept() const { return not_kept_; }
  const std::vector<ToldTick>& kept() const { return kept_; }

 private:
  void check_file() const;
  void read(const ToldTick& tick);
  void begin_episode(const ToldTick& tick);
  void draw();

  const TickReaderOptions options_;
  LiveLine& line_;
  DetectSummary& summary_;
  std::ofstream file_;
  std::vector<ToldTick> ticks_, kept_;
  std::optional<ToldTick> newest_;
  std::uint64_t skipped_ = 0, not_kept_ = 0;
  Touch last_ = Touch::none;
  std::uint32_t beginning_ = 0;
  bool episode_is_kept_ = false;
  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now(), drawn_{};
};

}  // namespace tactile
