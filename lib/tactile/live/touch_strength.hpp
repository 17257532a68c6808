#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace tactile::live {

/// Compares how strongly touches show in the runs of a session. Out of focus, or with less light, they cause fewer events. One
/// run alone does not tell: other skins and objects cause other numbers.
///
/// The strength of a run is its highest event rate over 0.1 s, less its lowest. A run whose strength is below a quarter of the
/// median of at least three earlier ones is worth a warning, and no measure for later ones; nor is a run that is repeated. The
/// limit is ours: twenty simulated runs of ten objects have 0.43 to
/// 2.95 of their median. With edges blurred over 15 px instead of 1.5 the same runs have 0.03 to 0.07 of their own strength, over
/// 6 px 0.3 to 0.65.
class TouchStrength {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// The number of events of the run so far. @param run  its name; empty between runs
  void see(const std::string& run, std::uint64_t events, Time now);

  /// About the last run that has ended: a sentence without its end; nothing if it is like the earlier ones.
  const std::optional<std::string>& warning() const { return warning_; }

 private:
  void begin(const std::string& run, std::uint64_t events, Time now);
  void end();

  std::string run_;
  std::uint64_t counted_ = 0, newest_ = 0;  ///< events at the start of the window, and now
  Time window_{};
  std::vector<double> rates_;      ///< of the run's windows [1/s]
  std::vector<double> strengths_;  ///< of the earlier runs [1/s]
  std::string newest_of_them_;     ///< the run that the last one is of
  std::optional<std::string> warning_;
};

}  // namespace tactile::live
