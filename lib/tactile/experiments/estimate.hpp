#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace tactile::experiments {

/// A part of an experiment that is not run yet.
struct EstimatedPart {
  std::string what;         ///< "trainings"
  std::size_t count = 0;    ///< runs, trainings, …
  std::size_t exist = 0;    ///< of these, that exist already
  double seconds = 0;       ///< processor time of the others
  double bytes = 0;         ///< that the others write
  bool one_thread = false;  ///< each of them runs in one thread, several side by side; with --executor slurm each is a job
  bool is_serial = false;   ///< all of them run in one thread, one after the other

  /// How long it takes on so many cores [s].
  double seconds_on(unsigned cores) const;
};

/// How large an experiment is.
struct Estimate {
  std::vector<EstimatedPart> parts;
  unsigned cores = 1;       ///< those that it would use here
  double images_per_s = 0;  ///< as `measured_training_speed`
  std::string data;         ///< what the numbers of samples and ticks are taken from

  /// Leaves out a part of nothing. @param seconds, bytes  of each
  void add(EstimatedPart part, double seconds, double bytes);

  double processor_seconds() const;
  /// How long it takes if the parts of one thread run on `jobs` cores and the others on `here` [s].
  double seconds_on(unsigned here, unsigned jobs) const;
  double bytes() const;
};

/// Of a second of a simulated run: all its files. Mean of 30 runs.
inline constexpr double bytes_of_second = 1.9e6;

/// What work costs on the machine that the figures were measured on: processor time [s] of one unit.
struct WorkCost {
  double simulated_second, labelled_second, second_of_windows;  ///< of a run
  double heatmap, training_start, judged_sample;
  double stream_step;                 ///< of a training
  double evaluation, evaluated_tick;  ///< of a training, and for each tick of the runs that it is judged on
  double stressed_tick;               ///< a tick of a run that is worsened, and judged
};

/// The costs on this machine: the measured ones, by the ratio of the speeds in training the usual network.
/// @param usual_images_per_s  `measured_training_speed` of the usual network
WorkCost work_cost(double usual_images_per_s);

}  // namespace tactile::experiments
