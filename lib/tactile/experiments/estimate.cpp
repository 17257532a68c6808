#include "tactile/experiments/estimate.hpp"

#include <algorithm>
#include <utility>

namespace tactile::experiments {

double EstimatedPart::seconds_on(unsigned cores) const {
  if (is_serial) return seconds;
  if (!one_thread || count <= exist) return seconds / cores;
  const std::size_t due = count - exist, rounds = (due + cores - 1) / cores;
  return seconds / static_cast<double>(due) * static_cast<double>(rounds);
}

void Estimate::add(EstimatedPart part, double seconds, double bytes) {
  if (part.count == 0) return;
  part.exist = std::min(part.exist, part.count);
  const auto due = static_cast<double>(part.count - part.exist);
  part.seconds = due * seconds;
  part.bytes = due * bytes;
  parts.push_back(std::move(part));
}

double Estimate::processor_seconds() const {
  double sum = 0;
  for (const EstimatedPart& part : parts) sum += part.seconds;
  return sum;
}

double Estimate::seconds_on(unsigned here, unsigned jobs) const {
  double sum = 0;
  for (const EstimatedPart& part : parts) sum += part.seconds_on(part.one_thread ? jobs : here);
  return sum;
}

double Estimate::bytes() const {
  double sum = 0;
  for (const EstimatedPart& part : parts) sum += part.bytes;
  return sum;
}

WorkCost work_cost(double usual_images_per_s) {
  // `reproduce --preset quick --threads 1` on an Intel Xeon at 2.5 GHz, on 2026-11-27: its 30 trainings of 3690 heatmaps and six
  // epochs took 24.4 s each.
  constexpr double measured_images_per_s = 967;
  const double slower = measured_images_per_s / usual_images_per_s;
  return {.simulated_second = slower * 0.21,
          .labelled_second = slower * 0.185,
          .second_of_windows = slower * 0.055,
          .heatmap = slower * 4.1e-4,
          .training_start = slower * 1.5,
          .judged_sample = slower * 5.2e-4,
          .stream_step = slower * 0.1,
          .evaluation = slower * 14.5,
          .evaluated_tick = slower * 5.5e-4,
          .stressed_tick = slower * 1.1e-3};
}

}  // namespace tactile::experiments
