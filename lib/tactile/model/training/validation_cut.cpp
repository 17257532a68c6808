#include "tactile/model/training/validation_cut.hpp"

#include <algorithm>
#include <cmath>

namespace tactile::model {
namespace {

/// The validation samples of one run: the last of each class.
std::vector<bool> last_of_each_class(std::span<const windows::Sample> run, double share) {
  std::vector<bool> last(run.size(), false);
  for (const Touch touch : all_touches) {
    const auto is_of_it = [touch](const windows::Sample& sample) { return sample.touch == touch; };
    auto left = static_cast<std::size_t>(share * static_cast<double>(std::count_if(run.begin(), run.end(), is_of_it)));
    for (std::size_t i = run.size(); i-- > 0 && left > 0;) {
      if (!is_of_it(run[i])) continue;
      last[i] = true;
      --left;
    }
  }
  return last;
}

}  // namespace

ValidationCut cut_in_time(std::span<const windows::Sample> samples, double share, microseconds history) {
  ValidationCut cut;
  for (std::size_t begin = 0, end = 0; begin < samples.size(); begin = end) {
    while (end < samples.size() && samples[end].run_index == samples[begin].run_index) ++end;
    const auto run = samples.subspan(begin, end - begin);
    const auto judged = last_of_each_class(run, share);
    std::vector<CameraTime> times;  // of the validation samples, ascending
    for (std::size_t i = 0; i < run.size(); ++i) {
      if (judged[i]) times.push_back(run[i].t);
    }
    for (std::size_t i = 0; i < run.size(); ++i) {
      const auto index = static_cast<std::uint32_t>(begin + i);
      if (judged[i]) {
        cut.validation.push_back(index);
        continue;
      }
      const auto next = std::lower_bound(times.begin(), times.end(), run[i].t);
      const bool near_next = next != times.end() && between(run[i].t, *next) < history;
      const bool near_last = next != times.begin() && between(*(next - 1), run[i].t) < history;
      if (!near_next && !near_last) cut.training.push_back(index);
    }
  }
  return cut;
}

}  // namespace tactile::model
