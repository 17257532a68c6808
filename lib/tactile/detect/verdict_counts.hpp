#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "tactile/core/touch.hpp"
#include "tactile/detect/reported_tick.hpp"

namespace tactile::detect {

/// A maximal sequence of ticks with one verdict other than none, without a restart of the stream.
struct VerdictEpisode {
  Touch touch = Touch::none;
  CameraTime first{}, last{};
  std::optional<CameraTime> confirmed{};  ///< of a slip: the first tick at which it is confirmed
};

/// What a tick changes: the episode that ended before it, whether one begins with it, and the slip that it confirms.
struct EpisodeChange {
  std::optional<VerdictEpisode> ended, confirmed;
  bool begins = false;
};

/// Counts ticks and episodes by verdict.
struct VerdictCounts {
  static constexpr std::size_t most_episodes = 10'000;  ///< that are listed; further ones are only counted

  std::array<std::uint64_t, touch_count> ticks{}, episodes{};  ///< by verdict
  std::uint64_t confirmed_slips = 0;
  std::vector<VerdictEpisode> first_episodes;
  std::optional<CameraTime> first_tick, last_tick;

  /// Ticks in order of time.
  EpisodeChange add(const ReportedTick& tick) {
    const CameraTime t = tick.verdict.t;
    const Touch touch = tick.verdict.verdict;
    ++ticks[static_cast<std::size_t>(touch)];
    if (!first_tick) first_tick = t;
    last_tick = t;
    EpisodeChange change;
    if (present_ && (present_->touch != touch || beginning_ != tick.beginning)) change.ended = end();
    beginning_ = tick.beginning;
    if (touch == Touch::none) return change;
    change.begins = !present_;
    if (change.begins) {
      ++episodes[static_cast<std::size_t>(touch)];
      is_listed_ = first_episodes.size() < most_episodes;
      present_ = VerdictEpisode{touch, t, t};
      if (is_listed_) first_episodes.push_back(*present_);
    }
    present_->last = t;
    if (tick.verdict.slip_is_confirmed && !present_->confirmed) {
      present_->confirmed = t;
      change.confirmed = present_;
      ++confirmed_slips;
    }
    if (is_listed_) first_episodes.back() = *present_;
    return change;
  }

  /// No tick follows. @return  the present episode, if any
  std::optional<VerdictEpisode> end() { return std::exchange(present_, std::nullopt); }

 private:
  std::optional<VerdictEpisode> present_;
  std::uint32_t beginning_ = 0;
  bool is_listed_ = false;  ///< the present episode
};

}  // namespace tactile::detect
