#pragma once

#include <cstddef>

#include "tactile/labels/exchange/exchanged_labels.hpp"

namespace tactile::labels {

/// The outcome for a run's intervals.
struct EditCounts {
  std::size_t kept = 0;       ///< both ends as exported, within the tool's rounding; they stay exact
  std::size_t confirmed = 0;  ///< of those, newly confirmed
  std::size_t moved = 0;      ///< an end or the class has changed
  std::size_t added = 0;
  std::size_t rejected = 0;  ///< removed in the tool

  std::size_t edits() const { return confirmed + moved + added + rejected; }
};

/// Applies a person's edits in another tool to the labels.
///
/// An imported interval is matched by its id, otherwise by class and time, otherwise by class and overlap; otherwise it is new.
/// An end at its exported time, within the file's resolution, keeps its exact time and uncertainty. A moved end gets the file's
/// time, and the file's rounding as uncertainty; with the origin `video`, hypot(rounding, 95 % of the film's clock there). A
/// moved or new interval has the `source` person and is confirmed, and its flags are confirmed; its evidence stays. A removed
/// interval is `rejected`. Ends that differ only by rounding are made equal.
///
/// @param times  the file's axis
/// @throws Error  with the interval: two have the same id, or one has no positive length, lies outside the recording, overlaps
///                another, or is moved in times of a film whose clock the labels lack
Labels with_edits(Labels labels, const ImportedLabels& imported, const FileTimes& times, CameraTime first_event,
                  CameraTime last_event, EditCounts& counts);

}  // namespace tactile::labels
