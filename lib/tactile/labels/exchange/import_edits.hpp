#pragma once

#include <cstddef>

#include "tactile/labels/exchange/exchanged_labels.hpp"

namespace tactile {

/// What became of a run's intervals.
struct EditCounts {
  std::size_t kept = 0;       ///< both ends as exported, to the tool's rounding: exact as before
  std::size_t confirmed = 0;  ///< of those, newly confirmed
  std::size_t moved = 0;      ///< an end or the class is another
  std::size_t added = 0;
  std::size_t rejected = 0;  ///< no longer there

  std::size_t edits() const { return confirmed + moved + added + rejected; }
};

/// The labels with what a person did to them in another tool.
///
/// An imported interval is that of its id, else the one of its class that lies where it does, else one of its class that it
/// overlaps, else a new one. An end that lies where it was exported, as near as the file can tell, keeps its exact time and
/// uncertainty; one that was moved has the file's, and the file's rounding for low and high. An interval that was moved or made
/// is a person's
/// (`source`) and confirmed, and the flags on it are lifted; its evidence stays. One that is no longer there is `rejected`. Ends
/// that meet but for the rounding are made to meet.
///
/// @param times  the file's axis
/// @throws Error  naming the interval: two of one id, one that is a mere point or ends before it starts, lies outside of the
/// recording, or overlaps another
Labels with_edits(Labels labels, const ImportedLabels& imported, const FileTimes& times, CameraTime first_event,
                  CameraTime last_event, EditCounts& counts);

}  // namespace tactile
