#pragma once

#include <string>

#include "tactile/labels/labels.hpp"

namespace tactile::labels {

/// Who makes an edit, and why.
struct EditNote {
  std::string who, why;
};

/// `after` with one more edit in the history of `before`. Edits that were undone can no longer be redone.
/// @param what  the edit in words
/// @param when  as `HistoryEntry` has it
Labels recorded(const Labels& before, Labels after, const EditNote& note, std::string what, std::string when);

/// The labels without their last `count` edits. @throws Error  if there are fewer, or one cannot be undone
Labels undone(Labels labels, std::size_t count = 1);
/// The last `count` undone edits, made again. @throws Error  as `undone`
Labels redone(Labels labels, std::size_t count = 1);

/// New labels of `tactile label`, with a person's edits of the `old` ones (`keep_human_edits`) and their history. Each edit can
/// be undone as before: what then appears under it is the new label.
Labels relabelled(const Labels& fresh, const Labels& old);
/// New labels without a person's edits. That is an edit itself, so that it can be undone.
Labels relabelled_without_edits(Labels fresh, const Labels& old, const EditNote& note);

}  // namespace tactile::labels
