#pragma once

#include "tactile/labels/labels.hpp"

namespace tactile {

/// Whether anything in these labels is a person's: an interval made, moved or confirmed, one rejected, or a flag confirmed.
bool has_human_edits(const Labels& labels);

/// Labels that were made anew, with what a person did to the `old` ones.
///
/// - Clocks, provenance, evidence and flags are the fresh ones, and so are intervals that no person's says anything of.
/// - An interval that a person made, moved or confirmed stays as it was. A fresh one that overlaps it is dropped, its evidence
/// going to the person's, if it is of the same class or lies in it by more than half; else the later start ends the earlier
/// interval, and where the later is the fresh one it begins at the person's end and is flagged.
/// - A fresh interval of the class that overlaps a rejected one is dropped.
/// - A flag is confirmed if it is on a person's interval, or one of the same words was confirmed, on the whole run or on an
/// interval of the class that overlaps it.
///
/// Ids of a person's intervals stay; a fresh one of the same id gets another.
Labels keep_human_edits(Labels fresh, const Labels& old);

}  // namespace tactile
