#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tactile/core/time.hpp"

namespace tactile::labels {

/// What happens to the skin.
enum class Happening : std::uint8_t {
  untouched,    ///< at rest, nothing touches it
  press,        ///< an object comes, or comes closer
  held,         ///< an object rests on it
  carried,      ///< an object rests on it and comes along with the arm
  slip,         ///< the object slides along it, or begins to
  release,      ///< the object leaves
  firm_shear,   ///< the start of a lift that takes the object along
  knock,        ///< any other short motion while nothing touches it
  disturbance,  ///< any other short motion while an object touches it: micro-slip, turn, vibration
};
constexpr std::size_t happenings = 9;
constexpr bool has_motion(Happening happening) {
  return happening != Happening::untouched && happening != Happening::held && happening != Happening::carried;
}

/// How much moves: the events of the motion, all places together [per ms].
constexpr std::array<double, 9> motion_levels{0, 0.35, 1, 3, 9, 27, 81, 250, 750};

/// The classes of the arm's speed [mm/s], each by its middle.
constexpr std::array<double, 7> arm_speeds{0.5, 1.5, 4, 10, 25, 60, 150};
/// What the arm does in a bin, as one number: it is still, moves at a speed from 1 to 7, begins to move, has just stopped, or is
/// not known; or it sets the sensor down on something for an instant, a sync tap. Without a log, an IMU shows
/// whether the camera moves, or a film whether anything does, be it the stage or the arm.
constexpr std::size_t arm_conditions = arm_speeds.size() + 9;
constexpr std::uint8_t arm_still = 0, arm_starts = arm_speeds.size() + 1, arm_stopped = arm_starts + 1,
                       arm_unknown = arm_starts + 2;
constexpr std::uint8_t film_still = arm_unknown + 1, film_moves = arm_unknown + 2, arm_taps = arm_unknown + 3;
constexpr std::uint8_t camera_still = arm_unknown + 4, camera_moves = arm_unknown + 5;
constexpr bool arm_moves(std::size_t condition) { return condition != arm_still && condition <= arm_starts; }
/// Of an arm that moves. It begins with the lowest speed.
constexpr std::size_t speed_of_arm(std::size_t condition) { return condition == arm_starts ? 1 : condition; }

/// Probabilities of going from each state to each other within a bin, for one condition of the arm. What leaves a happening
/// enters another one through an entry: all that enter there begin alike. So
///
///   p(to | from) = within(from, to) + sum over entries of leaving(from, entry) entering(entry, to)
struct StateTransitions {
  struct Step {
    std::uint16_t to;
    double probability;  ///< > 0
  };
  /// A sparse matrix, by row.
  class Steps {
   public:
    void add_row(std::span<const double> row);
    std::size_t rows() const { return first_.size() - 1; }
    std::span<const Step> of(std::size_t row) const {
      return std::span(steps_).subspan(first_[row], first_[row + 1] - first_[row]);
    }

   private:
    std::vector<std::uint32_t> first_{0};
    std::vector<Step> steps_;
  };
  static constexpr std::size_t most_entries = 2 * happenings + 6;  ///< each begins at rest or rising, some move on or become even

  Steps within;             ///< [from, to]
  Steps leaving, entering;  ///< [from, entry], [entry, to]
  Steps backwards;          ///< [to, from]: the whole p(to | from), to draw paths
};

/// The states of the hidden Markov chain: what happens, in which phase, at which level of motion.
///
/// A happening with motion first rises: its level only grows. Or, in half of the shears by an arm, the events follow the arm's
/// speed: such a state has a gain instead of a level, and its level is higher by one for each step of `arm_speeds`. Then the
/// level wanders. A slip may also stick, or slide smoothly without events; press, slip and release may last long with few.
class RunStates {
 public:
  /// @param several_runs  in the recording: between two of them an object may leave the skin without an event
  explicit RunStates(microseconds bin, bool several_runs = false);

  std::size_t count() const { return happening_of_.size(); }
  Happening happening_of(std::size_t state) const { return happening_of_[state]; }
  std::size_t level_of(std::size_t state, std::uint8_t arm_condition) const {
    return level_of_[state * arm_conditions + arm_condition];
  }
  const std::vector<double>& at_start() const { return at_start_; }
  const StateTransitions& transitions(std::uint8_t arm_condition) const { return transitions_[arm_condition]; }

 private:
  std::vector<Happening> happening_of_;
  std::vector<std::uint8_t> level_of_;  ///< [state, arm condition]
  std::vector<double> at_start_;
  std::array<StateTransitions, arm_conditions> transitions_;
};

}  // namespace tactile::labels
