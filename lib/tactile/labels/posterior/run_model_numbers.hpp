#pragma once

#include <array>
#include <cstddef>

/// The numbers of the model of a run, with units and sources. docs/numerics/labels.md has the formulas that they stand in.
namespace tactile::labels::numbers {

inline constexpr double slack_mm = 0.12;  ///< way of the arm until it shears the skin, mean: play and compliance of the mount
inline constexpr double without_slack = 0.25;  ///< of the mounts: they have no play, and the skin shears at once
inline constexpr double start_shakes = 0.2;    ///< of the lifts, those whose start shakes the skin before it shears
inline constexpr double gain_grows_s = 0.020;  ///< until more of the skin follows: a factor of three in events
inline constexpr double follows_arm_s = 0.03;  ///< shear follows the arm for this long, mean; then tips begin to slip
/// In a recording of several runs, how often per second an object leaves the skin without an event: while the arm rests by its
/// log, or after a lift.
inline constexpr double held_object_leaves = 0.3, carried_object_leaves = 1;
inline constexpr double slips = 0.94;  ///< share of the lifts in which the object slips

/// Of the level at which a motion begins, in the order of `motion_levels`: a fifth causes no event at first.
inline constexpr std::array<double, 9> first_level{0.20, 0.08, 0.10, 0.11, 0.12, 0.13, 0.12, 0.09, 0.05};
inline constexpr double rise_s = 0.0025;  ///< from one level to the next while a motion begins
/// How long a motion stays at a level, lowest first; the last one is of all others.
inline constexpr std::array<double, 5> level_lasts_s{0.002, 0.004, 0.005, 0.006, 0.010};
inline constexpr double slides_s = 0.3;  ///< the same while an object slides evenly

inline constexpr std::size_t creep_levels = 3;                             ///< highest level of a skin that creeps after a motion
inline constexpr std::array<double, 4> creep_after{0.5, 0.15, 0.2, 0.15};  ///< of the level right after it
inline constexpr double creep_s = 0.1;                                     ///< until it falls to the next level

inline constexpr double changes_unrecorded = 0.05;  ///< of the starts and stops of an arm, those outside the recording
inline constexpr double counted = 0.5;  ///< part of the evidence on the robot's clock: the model's motions are not exact
inline constexpr double arm_to_skin_us = 12'000;  ///< standard deviation of the time that the skin follows the arm by
inline constexpr double imu_lag_us = 2'000;       ///< most that the IMU's own filter delays it

inline constexpr double end_known_ms = 9;  ///< standard deviation of what is the end of a motion that fades

}  // namespace tactile::labels::numbers
