#pragma once

#include "tactile/labels/labels.hpp"

namespace tactile::labels {

/// Whether a person edited these labels: made, moved, confirmed or rejected an interval, or confirmed a flag.
bool has_human_edits(const Labels& labels);

/// The new labels, with a person's edits of the `old` ones.
///
/// - Clocks, provenance, evidence and flags are the new ones, and so are intervals that no person has touched.
/// - An interval that a person made, moved or confirmed stays. A new one that overlaps it is dropped if it has the same class or
///   lies in it by more than half, and also one of its class that holds its onset by the events: it was moved from there; if it
///   has the same class, its evidence goes to the person's. Else the person's start ends the new interval; a new interval that
///   starts within the person's begins at the person's end and is flagged.
/// - A new interval of the same class as a rejected one that it overlaps is dropped.
/// - A flag is confirmed if it is on a person's interval, or if a flag with the same key was confirmed on the whole run or on
///   an overlapping interval of the class.
///
/// Ids of a person's intervals stay; a new one with the same id gets another.
Labels keep_human_edits(Labels fresh, const Labels& old);

}  // namespace tactile::labels
