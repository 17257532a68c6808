#include "tactile/labels/posterior/run_posterior.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tactile/core/robust_statistics.hpp"
#include "tactile/labels/posterior/arm_course.hpp"
#include "tactile/labels/posterior/imu_evidence.hpp"
#include "tactile/labels/posterior/motion_evidence.hpp"
#include "tactile/labels/posterior/press_pattern.hpp"
#include "tactile/labels/posterior/state_paths.hpp"

namespace tactile::labels {
namespace {

constexpr microseconds fine_bin = 1000us;
constexpr std::size_t coarse_bins = 8, paths_of_round = 60, paths_at_end = 400;
constexpr double negligible = 12;  // [nats] below the likeliest offset

using Path = std::vector<std::uint16_t>;

struct Offset {
  std::int64_t us = 0;
  double log_evidence = 0;
};

/// Paths that were drawn with one offset of the robot's clock.
struct DrawnPaths {
  std::int64_t offset_us = 0;            ///< without a log: 0
  std::vector<std::uint8_t> conditions;  ///< of the arm, in each bin
  std::vector<Path> paths;
};

/// A stretch of one happening in a path, in bins.
struct Stretch {
  Happening happening;
  std::size_t begin, end;
};

std::vector<Stretch> stretches_of(const Path& path, const RunStates& states) {
  std::vector<Stretch> stretches;
  for (std::size_t b = 0; b < path.size(); ++b) {
    const Happening happening = states.happening_of(path[b]);
    if (stretches.empty() || stretches.back().happening != happening) stretches.push_back({happening, b, b});
    stretches.back().end = b + 1;
  }
  return stretches;
}

class Inference {
 public:
  explicit Inference(const alignment::RunSignals& signals)
      : signals_(signals),
        counts_(counts_in(signals)),
        states_(counts_.bin),
        coarse_states_(counts_.bin * static_cast<std::int64_t>(coarse_bins)),
        rates_(first_rates(counts_)) {
    for (const alignment::RobotPiece& piece : signals.robot) {
      if (piece_ == nullptr || piece.log.states.size() > piece_->log.states.size()) piece_ = &piece;
    }
    const auto motion = piece_ != nullptr ? alignment::arm_motion(piece_->log) : std::nullopt;
    if (!motion) return;
    arm_.emplace(*motion);
    if (!arm_->moves_at_all()) arm_.reset();
    if (arm_ && !signals.imu.empty()) imu_.emplace(signals.imu, *motion);
    if (imu_ && imu_->empty()) imu_.reset();
  }

  RunPosterior posterior() {
    evidence_ = motion_evidence(counts_, rates_);
    for (int round = 0; round < 2; ++round) {
      draw(paths_of_round, round == 0);
      learn();
      evidence_ = motion_evidence(counts_, rates_);
    }
    draw(paths_at_end, false);
    return {.touches = touches(), .releases = releases(), .robot = offset()};
  }

 private:
  static PlaceCounts counts_in(const alignment::RunSignals& signals) {
    events::RecordingReader recording(signals.run.events());
    return place_counts(recording, signals.event_stream, signals.rate, fine_bin);
  }

  /// The evidence of several bins together.
  std::vector<double> joined(const std::vector<double>& values, std::size_t width) const {
    const std::size_t bins = counts_.bins() / coarse_bins;
    std::vector<double> sums(bins * width, 0.0);
    for (std::size_t b = 0; b < bins * coarse_bins; ++b) {
      for (std::size_t k = 0; k < width; ++k) sums[b / coarse_bins * width + k] += values[b * width + k];
    }
    return sums;
  }

  /// Offsets that the log may have before its content is looked at.
  std::pair<std::int64_t, std::int64_t> possible_offsets() const {
    constexpr std::int64_t recorders_apart_us = 3'000'000;
    if (const auto& known = signals_.coarse_offsets[static_cast<std::size_t>(piece_ - signals_.robot.data())])
      return {known->offset_us - known->within.count(), known->offset_us + known->within.count()};
    const std::int64_t at_begin = us_of(signals_.rate.begin) - us_of(arm_->begin());
    const std::int64_t longer =
        (us_of(arm_->end()) - us_of(arm_->begin())) - (us_of(signals_.rate.last) - us_of(signals_.rate.begin));
    return {at_begin - std::max(recorders_apart_us, longer + 1'000'000), at_begin + recorders_apart_us};
  }

  /// A finer grid, within `around` of the likely offsets.
  static std::vector<std::int64_t> refined(const std::vector<Offset>& offsets, std::int64_t around_us, std::int64_t step_us,
                                           std::size_t most) {
    std::vector<Offset> likely = offsets;
    std::stable_sort(likely.begin(), likely.end(),
                     [](const Offset& a, const Offset& b) { return a.log_evidence > b.log_evidence; });
    std::vector<std::int64_t> finer;
    for (std::size_t i = 0; i < std::min(most, likely.size()); ++i) {
      if (likely[i].log_evidence < likely.front().log_evidence - negligible) break;
      for (std::int64_t d = -around_us; d <= around_us; d += step_us) finer.push_back(likely[i].us + d);
    }
    std::sort(finer.begin(), finer.end());
    finer.erase(std::unique(finer.begin(), finer.end()), finer.end());
    return finer;
  }

  double imu_at(std::int64_t offset_us) const { return imu_ ? imu_->of(offset_us) : 0; }

  std::vector<Offset> weighed(const std::vector<std::int64_t>& offsets, const BinLikelihoods& likelihoods,
                              const RunStates& states, microseconds bin) const {
    std::vector<Offset> weighed = imu_only(offsets);
    for (Offset& one : weighed) {
      const auto conditions = arm_->conditions(counts_.begin, bin, likelihoods.bins(), one.us);
      one.log_evidence += filtered(states, likelihoods, conditions, false).log_evidence;
    }
    return weighed;
  }

  std::vector<Offset> imu_only(const std::vector<std::int64_t>& offsets) const {
    std::vector<Offset> weighed(offsets.size());
    std::transform(offsets.begin(), offsets.end(), weighed.begin(), [this](std::int64_t us) { return Offset{us, imu_at(us)}; });
    return weighed;
  }

  /// The IMU distinguishes offsets that lie between those of the grid.
  std::vector<Offset> with_imu_between(const std::vector<Offset>& grid, std::int64_t step) const {
    std::vector<Offset> finer;
    for (const Offset& one : grid) {
      const double events = one.log_evidence - imu_at(one.us);
      for (std::int64_t us = one.us - step / 2; us < one.us + step / 2; us += 8'000) finer.push_back({us, events + imu_at(us)});
    }
    return finer;
  }

  /// The likely offsets of the robot's clock, on a grid that becomes finer.
  std::vector<Offset> likely_offsets(bool anywhere, const BinLikelihoods& likelihoods) const {
    const auto all = joined(evidence_, motion_levels.size());
    const auto patterns = pattern_.empty() ? std::vector<double>() : joined(pattern_, happenings);
    const BinLikelihoods coarse(all, patterns);
    const auto weighed_coarsely = [&](const std::vector<std::int64_t>& us) {
      return weighed(us, coarse, coarse_states_, counts_.bin * static_cast<std::int64_t>(coarse_bins));
    };
    std::vector<Offset> offsets = offsets_;
    if (anywhere || offsets.empty()) {
      const auto [low, high] = possible_offsets();
      std::vector<std::int64_t> grid;
      const std::int64_t step = std::min<std::int64_t>(32'000, std::max<std::int64_t>(8'000, (high - low) / 8));
      for (std::int64_t us = low; us <= high; us += step) grid.push_back(us);
      offsets = weighed_coarsely(grid);
      if (imu_) offsets = with_imu_between(offsets, step);
      offsets = weighed_coarsely(refined(offsets, imu_ ? 8'000 : step - 8'000, 8'000, 12));
    } else {
      for (Offset& one : offsets) one.us = one.us / 8'000 * 8'000;
      offsets = weighed_coarsely(refined(offsets, 24'000, 8'000, 6));
    }
    if (imu_) offsets = imu_only(refined(offsets, 8'000, 1'000, 5));
    return weighed(imu_ ? refined(offsets, 0, 1'000, 15) : refined(offsets, 4'000, 4'000, 12), likelihoods, states_, counts_.bin);
  }

  /// Draws paths from the posterior, with an offset of the clock each.
  void draw(std::size_t count, bool anywhere) {
    Random random(1);
    const BinLikelihoods likelihoods(evidence_, pattern_);
    drawn_.clear();
    const auto draw_from = [&](std::int64_t offset_us, std::vector<std::uint8_t> conditions, std::size_t times) {
      const Filtered kept = filtered(states_, likelihoods, conditions, true);
      DrawnPaths& drawn = drawn_.emplace_back(DrawnPaths{offset_us, std::move(conditions), {}});
      for (std::size_t i = 0; i < times; ++i) drawn.paths.push_back(drawn_path(states_, kept, drawn.conditions, random));
    };
    if (!arm_) return draw_from(0, std::vector<std::uint8_t>(counts_.bins(), arm_unknown), count);
    offsets_ = likely_offsets(anywhere, likelihoods);
    double most = -1e300, sum = 0;
    for (const Offset& one : offsets_) most = std::max(most, one.log_evidence);
    for (const Offset& one : offsets_) sum += std::exp(one.log_evidence - most);
    std::vector<std::size_t> times(offsets_.size(), 0);
    for (std::size_t i = 0; i < count; ++i) {
      double left = (static_cast<double>(i) + random.uniform()) / static_cast<double>(count) * sum;
      std::size_t k = 0;
      while (k + 1 < offsets_.size() && (left -= std::exp(offsets_[k].log_evidence - most)) >= 0) ++k;
      ++times[k];
    }
    for (std::size_t k = 0; k < offsets_.size(); ++k) {
      const std::int64_t us = offsets_[k].us;
      if (times[k] > 0) draw_from(us, arm_->conditions(counts_.begin, counts_.bin, counts_.bins(), us), times[k]);
    }
  }

  template <class Use>
  void for_all_paths(Use use) const {
    for (const DrawnPaths& drawn : drawn_) {
      for (const Path& path : drawn.paths) use(path, drawn);
    }
  }

  double share_of_path() const {
    std::size_t count = 0;
    for (const DrawnPaths& drawn : drawn_) count += drawn.paths.size();
    return 1.0 / static_cast<double>(count);
  }

  /// Rates of noise and motion, and the pattern of the first press, from the drawn paths.
  void learn() {
    const double each = share_of_path();
    std::vector<double> quiet(counts_.bins(), 0.0), moves(counts_.bins(), 0.0), strong(counts_.bins(), 0.0);
    for_all_paths([&](const Path& path, const DrawnPaths& drawn) {
      for (std::size_t b = 0; b < path.size(); ++b) {
        const std::size_t level = states_.level_of(path[b], drawn.conditions[b]);
        const Happening happening = states_.happening_of(path[b]);
        if (level == 0 && happening != Happening::slip) quiet[b] += each;
        if (level >= 3) strong[b] += each;
        if (level > 0 && happening != Happening::held && happening != Happening::carried) moves[b] += each;
      }
    });
    if (std::accumulate(quiet.begin(), quiet.end(), 0.0) > 200) rates_ = rates_given(counts_, quiet, strong);
    const std::vector<LikelyTouch> found = touches();
    const auto press = std::find_if(found.begin(), found.end(),
                                    [](const LikelyTouch& one) { return one.touch == Touch::press && one.probability > 0.3; });
    if (press == found.end()) return;
    const auto bin_of = [&](CameraTime t) { return static_cast<std::size_t>(between(counts_.begin, t) / counts_.bin); };
    pattern_ = pattern_evidence(counts_, bin_of(press->start.at), std::min(counts_.bins(), bin_of(press->end.at) + 1), moves);
  }

  /// The presses and slips of each path. Slips with less than 150 ms between them are one slip that sticks.
  std::vector<std::vector<Stretch>> touches_of_paths() const {
    const auto sticks = static_cast<std::size_t>(150ms / counts_.bin);
    std::vector<std::vector<Stretch>> all;
    for_all_paths([&](const Path& path, const DrawnPaths&) {
      std::vector<Stretch>& touches = all.emplace_back();
      for (const Stretch& stretch : stretches_of(path, states_)) {
        if (stretch.happening != Happening::press && stretch.happening != Happening::slip) continue;
        const bool goes_on = !touches.empty() && stretch.happening == Happening::slip &&
                             touches.back().happening == Happening::slip && stretch.begin < touches.back().end + sticks;
        if (goes_on)
          touches.back().end = stretch.end;
        else
          touches.push_back(stretch);
      }
    });
    return all;
  }

  /// A touch that begins elsewhere is another one.
  void keep_near_median(std::vector<double>& starts, std::vector<double>& ends) const {
    const double near = 100'000.0 / static_cast<double>(counts_.bin.count());
    const double middle = value_of_rank(starts, starts.size() / 2);
    std::vector<double> kept_starts, kept_ends;
    for (std::size_t i = 0; i < starts.size(); ++i) {
      if (std::abs(starts[i] - middle) > near) continue;
      kept_starts.push_back(starts[i]);
      kept_ends.push_back(ends[i]);
    }
    starts.swap(kept_starts);
    ends.swap(kept_ends);
  }

  alignment::UncertainTime time_of(std::span<const double> bins) const {
    const auto at = [&](double share) {
      return after(counts_.begin, microseconds{std::llround(quantile(bins, share) * static_cast<double>(counts_.bin.count()))});
    };
    return {at(0.5), at(0.025), at(0.975)};
  }

  std::vector<LikelyTouch> touches() const {
    constexpr double least = 0.05;
    const auto of_paths = touches_of_paths();
    const double each = share_of_path();
    std::vector<LikelyTouch> found;
    Random random(2);
    for (const Happening happening : {Happening::press, Happening::slip}) {
      std::vector<double> probability(counts_.bins(), 0.0);
      for (const auto& touches : of_paths) {
        for (const Stretch& one : touches) {
          if (one.happening != happening) continue;
          for (std::size_t b = one.begin; b < one.end; ++b) probability[b] += each;
        }
      }
      for (std::size_t b = 0; b < probability.size();) {
        if (probability[b] < least) {
          ++b;
          continue;
        }
        std::size_t end = b, peak = b;
        for (; end < probability.size() && probability[end] >= least; ++end) {
          if (probability[end] > probability[peak]) peak = end;
        }
        std::vector<double> starts, ends;
        for (const auto& touches : of_paths) {
          for (const Stretch& one : touches) {
            if (one.happening != happening || one.begin > peak || one.end <= peak) continue;
            // A motion that is in a bin began somewhere in the one before, or in it.
            starts.push_back(static_cast<double>(one.begin) + random.uniform() - 0.5);
            ends.push_back(static_cast<double>(one.end) + random.uniform() - 0.5);
          }
        }
        keep_near_median(starts, ends);
        const double share = each * static_cast<double>(starts.size());
        found.push_back({happening == Happening::press ? Touch::press : Touch::slip, share, time_of(starts), time_of(ends)});
        b = end;
      }
    }
    std::stable_sort(found.begin(), found.end(),
                     [](const LikelyTouch& a, const LikelyTouch& b) { return a.start.at < b.start.at; });
    return found;
  }

  std::vector<TouchInterval> releases() const {
    std::vector<double> probability(counts_.bins(), 0.0);
    for_all_paths([&, each = share_of_path()](const Path& path, const DrawnPaths&) {
      for (std::size_t b = 0; b < path.size(); ++b)
        probability[b] += states_.happening_of(path[b]) == Happening::release ? each : 0;
    });
    std::vector<TouchInterval> found;
    for (std::size_t b = 0; b < probability.size(); ++b) {
      if (probability[b] <= 0.5) continue;
      if (found.empty() || found.back().end != counts_.begin_of(b))
        found.push_back({Touch::none, counts_.begin_of(b), counts_.begin_of(b)});
      found.back().end = counts_.begin_of(b + 1);
    }
    return found;
  }

  std::optional<LikelyOffset> offset() const {
    if (!arm_) return std::nullopt;
    std::vector<std::int64_t> sorted;
    for_all_paths([&](const Path&, const DrawnPaths& drawn) { sorted.push_back(drawn.offset_us); });
    const auto at = [&](double share) {
      return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
    };
    return LikelyOffset{at(0.5), at(0.025) - 1000, at(0.975) + 1000, piece_->log.states.front().t};
  }

  const alignment::RunSignals& signals_;
  PlaceCounts counts_;
  RunStates states_, coarse_states_;
  PlaceRates rates_;
  const alignment::RobotPiece* piece_ = nullptr;  ///< the longest of the robot's log
  std::optional<ArmCourse> arm_;                  ///< nothing if the arm rests, or there is no log
  std::optional<ImuEvidence> imu_;
  std::vector<double> evidence_, pattern_;
  std::vector<Offset> offsets_;
  std::vector<DrawnPaths> drawn_;  ///< by offset
};

}  // namespace

RunPosterior run_posterior(const alignment::RunSignals& signals) { return Inference(signals).posterior(); }

}  // namespace tactile::labels
