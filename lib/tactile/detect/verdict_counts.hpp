#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "tactile/core/touch.hpp"
#include "tactile/detect/reported_tick.hpp"

namespace tactile::detect {

/// A maximal sequence of ticks with one verdict other than none, without a restart of the stream.
struct VerdictEpisode {
  Touch touch = Touch::none;
  CameraTime first{}, last{};
};

/// Counts ticks and episodes by verdict.
struct VerdictCounts {
  static constexpr std::size_t most_episodes = 10'000;  ///< that are listed; further ones are only counted

  std::array<std::uint64_t, touch_count> ticks{}, episodes{};  ///< by verdict
  std::vector<VerdictEpisode> first_episodes;
  std::optional<CameraTime> first_tick, last_tick;

  /// Ticks in order of time. @return  whether an episode begins with this one
  bool add(const ReportedTick& tick) {
    const CameraTime t = tick.verdict.t;
    const Touch touch = tick.verdict.verdict;
    ++ticks[static_cast<std::size_t>(touch)];
    if (!first_tick) first_tick = t;
    last_tick = t;
    const bool continues = last_ == touch && beginning_ == tick.beginning;
    last_ = touch;
    beginning_ = tick.beginning;
    if (touch == Touch::none) return false;
    if (continues) {
      if (is_listed_) first_episodes.back().last = t;
      return false;
    }
    ++episodes[static_cast<std::size_t>(touch)];
    is_listed_ = first_episodes.size() < most_episodes;
    if (is_listed_) first_episodes.push_back({touch, t, t});
    return true;
  }

 private:
  Touch last_ = Touch::none;
  std::uint32_t beginning_ = 0;
  bool is_listed_ = false;  ///< the present episode
};

}  // namespace tactile::detect
