#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "tactile/alignment/film_clock.hpp"
#include "tactile/alignment/film_motions.hpp"

namespace tactile::alignment {

inline constexpr double usual_longer_us = 20'000;  ///< standard deviation of what a motion is longer by in the film

/// The relation of both times, in microseconds from the film's begin and from the speed's first value:
/// film + offset + drift * (film + offset - middle of the motions).
struct FilmLine {
  double offset = 0, drift = 0;
  double longer = 0;  ///< a motion in the film [us]
};

/// A film and the motion that it should have seen: how well they fit along a line.
class FilmMatch {
 public:
  /// A stretch of time, in microseconds from the first value of the speed.
  struct Stretch {
    double begin, end;

    double middle() const { return 0.5 * (begin + end); }
    double length() const { return end - begin; }
  };

  /// @param usual_drift  of the times of such films, standard deviation
  FilmMatch(const MotionEnergy& energy, const SeenMotion& seen, double usual_drift);

  /// Leaves out motions that the film does not reach, and takes the middle of those whose middle it has.
  /// @return the same line
  FilmLine without_unseen_moves(const FilmLine& line);

  const std::vector<Stretch>& moves() const { return moves_; }
  double middle() const { return middle_; }
  double frame_us() const { return frame_us_; }
  double span_us() const { return span_; }  ///< from the first motion's middle to the last one's
  double length_us() const { return step_us_ * static_cast<double>(integrals_.size() - 1); }
  double film_us() const { return steps_.back().end; }
  double usual_drift() const { return usual_drift_; }

  /// The film's time of a time of the speed, and the other way round.
  double on_film(const FilmLine& line, double seen) const { return middle_ + (seen - middle_) / (1 + line.drift) - line.offset; }
  double on_seen(const FilmLine& line, double film) const {
    return film + line.offset + line.drift * (film + line.offset - middle_);
  }

  /// How much of the film the motion explains.
  struct Explained {
    double steps = 0;   ///< independent ones of which the speed is known
    double moving = 0;  ///< the same while something moves
    double share = 0;   ///< of the variance of the energies, r^2

    double log_likelihood(double independent) const { return -0.5 * independent * std::log1p(-share); }
  };
  Explained explained(const FilmLine& line) const;

  /// ln p(film | line), 0 for a film that has nothing to do with the motion: where the motion lies.
  double log_likelihood(const FilmLine& line) const;

  /// What is usual of the times of films.
  double log_prior(const FilmLine& line) const;
  double log_posterior(const FilmLine& line) const { return log_likelihood(line) + log_prior(line); }

  /// Near the best line: rest says nothing there. @param moving  independent steps while something moves, at that line
  double log_posterior_near(const FilmLine& line, double moving) const {
    return explained(line).log_likelihood(moving) + log_prior(line);
  }

 private:
  struct Sums {  // weighted by the length of a step
    double w = 0, e = 0, ee = 0, independent = 0;

    Sums with(const FilmStep& step) const;
    Sums without(const Sums& other) const { return {w - other.w, e - other.e, ee - other.ee, independent - other.independent}; }
  };
  struct MovingSums {
    double v = 0, vv = 0, ev = 0, us = 0;
  };
  /// Steps of the film, [first, last).
  struct StepRange {
    std::size_t first, last;
  };

  void add_to(std::vector<Stretch>& stretches, std::size_t i, double apart_us) const;
  template <class Counts>
  void set_middle(Counts counts);
  double integral(double t) const;
  std::size_t first_after(const FilmLine& line, double seen) const;
  bool touches_gap(const FilmLine& line, const FilmStep& step) const;
  StepRange known_steps(const FilmLine& line) const;
  Sums sums_of(const FilmLine& line, const StepRange& known) const;
  void add_move(const FilmLine& line, const StepRange& known, std::size_t m, MovingSums& sums) const;

  std::vector<FilmStep> steps_;
  std::vector<Sums> sums_;         ///< of the steps before each
  std::vector<double> integrals_;  ///< of the speed, in steps
  std::vector<Stretch> moves_, gaps_;
  double step_us_, frame_us_, middle_ = 0, span_ = 0, usual_drift_;
};

}  // namespace tactile::alignment
