#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "tactile/alignment/motion_energy.hpp"
#include "tactile/core/random.hpp"

namespace tactile::alignment {

/// A motion along a straight line: speeds up, moves evenly, slows down.
struct MadeMotion {
  double start_s = 0, end_s = 0, speed = 1, ramp_s = 0.06;

  double travel(double t_s) const {
    const auto ramped = [&](double u) { return u <= 0 ? 0.0 : u < ramp_s ? 0.5 * u * u / ramp_s : u - 0.5 * ramp_s; };
    return speed * (ramped(t_s - start_s) - ramped(t_s - end_s + ramp_s));
  }
  double speed_at(double t_s) const { return (travel(t_s + 1e-5) - travel(t_s - 1e-5)) / 2e-5; }
};

constexpr std::int64_t run_begin_us = 1'700'000'000'000'000;

struct MadeFilm {
  std::vector<MadeMotion> motions = {};  ///< in seconds from the run's start, in camera time
  double begins_s = -0.7;                ///< the first frame
  double ends_s = 5;
  double rate_hz = 30;
  double drift_ppm = 0;
  double jitter = 0.05;        ///< of the times, in frames; 0: they count frames
  int repeats = 0;             ///< one time in so many repeats the one before, and its frame is dropped
  double gain_scatter = 0.03;  ///< of what a step shows of the displacement, relative
  std::uint64_t seed = 1;

  /// Camera time less video time, at the film's start.
  std::int64_t offset_us() const { return run_begin_us + std::llround(1e6 * begins_s); }
};

inline MotionEnergy film_of(const MadeFilm& made) {
  Random random(made.seed);
  MotionEnergy energy;
  energy.noise = 0.001;
  energy.threshold = 3;
  energy.median_step = microseconds{std::llround(1e6 / made.rate_hz)};
  VideoTime last{};
  const double camera_per_video = 1 + 1e-6 * made.drift_ppm;
  for (int i = 1;; ++i) {
    const VideoTime next{microseconds{std::llround(1e6 * (i + made.jitter * random.normal()) / made.rate_hz)}};
    if (made.repeats > 0 && i % made.repeats == 0) continue;
    const auto camera_s = [&](VideoTime t) { return made.begins_s + camera_per_video * 1e-6 * static_cast<double>(us_of(t)); };
    if (camera_s(next) > made.ends_s) break;
    double travel = 0;
    for (const MadeMotion& motion : made.motions) travel += motion.travel(camera_s(next)) - motion.travel(camera_s(last));
    const double change = travel * (1 + made.gain_scatter * random.normal()) + 0.5 * energy.noise * random.uniform();
    MotionStep step;
    step.begin = last;
    step.end = next;
    step.energy = std::max(0.0, change) / (1e-6 * static_cast<double>((next - last).count()));
    step.strongest = 15;
    energy.steps.push_back(step);
    last = next;
  }
  return energy;
}

inline const MadeMotion arm_lift{.start_s = 2.1, .end_s = 2.83, .speed = 10};
inline const MadeMotion closing{.start_s = 0.9, .end_s = 1.6, .speed = 0.6, .ramp_s = 0.02};

}  // namespace tactile::alignment
