#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "tactile/windows/dataset.hpp"

namespace tactile::model {

/// Calls `use` for each run with its samples. @param samples  indexes in the dataset, ascending
template <class Use>
void for_runs_of(const windows::Dataset& dataset, std::span<const std::uint32_t> samples, const Use& use) {
  while (!samples.empty()) {
    const std::uint32_t run = dataset.samples()[samples.front()].run_index;
    const auto next_run = std::find_if(samples.begin(), samples.end(),
                                       [&](std::uint32_t sample) { return dataset.samples()[sample].run_index != run; });
    const auto count = static_cast<std::size_t>(next_run - samples.begin());
    use(run, samples.first(count));
    samples = samples.subspan(count);
  }
}

/// Gives the events of a run, as the dataset stores them, to `add`, and calls `at` with the time of each sample once all events
/// before it are given.
/// @param samples  indexes in the dataset, of this run, ascending
/// @throws Error   if the dataset cannot be read
template <class Add, class At>
void follow_samples(const windows::Dataset& dataset, std::uint32_t run, std::span<const std::uint32_t> samples, const Add& add,
                    const At& at) {
  const std::vector<events::Event> events = dataset.events(run);
  auto given = events.begin();
  for (const std::uint32_t sample : samples) {
    const CameraTime t = dataset.samples()[sample].t;
    const auto end = std::partition_point(given, events.end(), [t](const events::Event& event) { return event.t < t; });
    add(std::span(given, end));
    at(t);
    given = end;
  }
}

}  // namespace tactile::model
