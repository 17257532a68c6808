#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

namespace tactile {

/// How long something took, over and over: a histogram whose bins are 1/32 of their time wide, so that a percentile is right
/// within 3 %, whatever its size. Of fixed size.
class DurationHistogram {
 public:
  void add(std::chrono::nanoseconds duration);  ///< below 0 counts as 0

  std::uint64_t count() const { return count_; }
  std::chrono::nanoseconds max() const { return max_; }  ///< exact; 0 of none
  double mean_us() const;                                ///< exact

  /// The time that at least this share of all does not exceed: the upper end of its bin, never above `max`. 0 of none.
  /// @param share  in (0, 1]
  std::chrono::nanoseconds percentile(double share) const;

  struct Bin {
    double from_us, to_us;
    std::uint64_t count;
  };
  /// Octaves that hold anything between the first and the last that do, in order.
  std::vector<Bin> octaves() const;

 private:
  static constexpr unsigned steps = 32;  ///< an octave
  static constexpr std::size_t bins = std::size_t{steps} * 60;
  static std::size_t bin_of(std::uint64_t ns);
  static std::uint64_t end_of(std::size_t bin);

  std::array<std::uint64_t, bins> counts_{};
  std::uint64_t count_ = 0;
  double sum_ns_ = 0;
  std::chrono::nanoseconds max_{0};
};

/// {"p50", "p99", "p999", "max", "mean"} in microseconds and "count"; null of none.
void to_json(nlohmann::json& json, const DurationHistogram& histogram);

/// One tick's way from its end to the verdict.
struct TickTimes {
  std::optional<std::chrono::nanoseconds> waiting;  ///< from the tick's end on the host to when it closed; not of what is played
  std::optional<std::chrono::nanoseconds> queued;   ///< until its heatmap was begun; likewise
  std::chrono::nanoseconds rendering{0}, network{0}, output{0};
};

/// Whether verdicts come in time. A tick is missed if it was skipped, or told more than one tick after it closed.
class DeadlineMonitor {
 public:
  explicit DeadlineMonitor(std::chrono::nanoseconds tick) : tick_(tick) {}

  void add(const TickTimes& times, std::uint64_t skipped);

  struct Counts {
    std::uint64_t told = 0, skipped = 0, late = 0;
    std::uint64_t missed() const { return skipped + late; }
    /// Of all ticks that should have been told; 0 of none.
    double missed_share() const;
  };
  const Counts& counts() const { return counts_; }

  const DurationHistogram& waiting() const { return waiting_; }
  const DurationHistogram& queued() const { return queued_; }
  const DurationHistogram& rendering() const { return rendering_; }
  const DurationHistogram& network() const { return network_; }
  const DurationHistogram& output() const { return output_; }
  const DurationHistogram& work() const { return work_; }      ///< rendering, network and output together
  const DurationHistogram& answer() const { return answer_; }  ///< from when the tick closed to its verdict: queued and work
  const DurationHistogram& whole() const { return whole_; }    ///< from the tick's end to its verdict

 private:
  std::chrono::nanoseconds tick_;
  Counts counts_;
  DurationHistogram waiting_, queued_, rendering_, network_, output_, work_, answer_, whole_;
};

}  // namespace tactile
