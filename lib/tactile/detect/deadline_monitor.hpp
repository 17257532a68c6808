#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

namespace tactile::detect {

/// A histogram of durations of fixed size. The width of a bin is 1/32 of its time, so that percentiles are accurate within 3 %.
class DurationHistogram {
 public:
  void add(std::chrono::nanoseconds duration);  ///< negative durations count as 0

  std::uint64_t count() const { return count_; }
  std::chrono::nanoseconds max() const { return max_; }  ///< exact; 0 if there is none
  double mean_us() const;                                ///< exact

  /// The time that at least this share of all durations does not exceed: the upper end of its bin, at most `max`. 0 if there is
  /// none.
  /// @param share  in (0, 1]
  std::chrono::nanoseconds percentile(double share) const;

  struct Bin {
    double from_us, to_us;
    std::uint64_t count;
  };
  /// The octaves from the first to the last that contain a duration.
  std::vector<Bin> octaves() const;

 private:
  static constexpr unsigned steps = 32;  ///< per octave
  static constexpr std::size_t bins = std::size_t{steps} * 60;
  static std::size_t bin_of(std::uint64_t ns);
  static std::uint64_t end_of(std::size_t bin);

  std::array<std::uint64_t, bins> counts_{};
  std::uint64_t count_ = 0;
  double sum_ns_ = 0;
  std::chrono::nanoseconds max_{0};
};

/// {"p50", "p99", "p999", "max", "mean"} in microseconds and "count"; null if there is none.
void to_json(nlohmann::json& json, const DurationHistogram& histogram);

/// The times of one tick from its end to the verdict.
struct TickTimes {
  std::optional<std::chrono::nanoseconds> waiting;  ///< from the tick's end, in host time, until it closed; not of replays
  std::optional<std::chrono::nanoseconds> queued;   ///< until its processing began; not of replays
  std::chrono::nanoseconds rendering{0}, network{0}, output{0};
};

/// Whether verdicts are in time. A tick is missed if it was skipped, or reported more than one tick after it closed.
class DeadlineMonitor {
 public:
  explicit DeadlineMonitor(std::chrono::nanoseconds tick) : tick_(tick) {}

  void add(const TickTimes& times, std::uint64_t skipped);

  struct Counts {
    std::uint64_t reported = 0, skipped = 0, late = 0;
    std::uint64_t missed() const { return skipped + late; }
    /// Share of all ticks that should have been reported; 0 if there is none.
    double missed_share() const;
  };
  const Counts& counts() const { return counts_; }

  const DurationHistogram& waiting() const { return waiting_; }
  const DurationHistogram& queued() const { return queued_; }
  const DurationHistogram& rendering() const { return rendering_; }
  const DurationHistogram& network() const { return network_; }
  const DurationHistogram& output() const { return output_; }
  const DurationHistogram& work() const { return work_; }      ///< rendering, network and output together
  const DurationHistogram& answer() const { return answer_; }  ///< from when the tick closed until its verdict: queued and work
  const DurationHistogram& whole() const { return whole_; }    ///< from the tick's end until its verdict

 private:
  std::chrono::nanoseconds tick_;
  Counts counts_;
  DurationHistogram waiting_, queued_, rendering_, network_, output_, work_, answer_, whole_;
};

}  // namespace tactile::detect
