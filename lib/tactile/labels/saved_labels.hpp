#pragma once

#include <functional>
#include <optional>
#include <string>
#include <variant>

#include "tactile/core/run_folder.hpp"
#include "tactile/labels/label_edit.hpp"
#include "tactile/labels/label_history.hpp"
#include "tactile/labels/labels.hpp"

namespace tactile::labels {

/// Labels as they were read or saved, with the SHA-256 of their labels.json.
struct VersionedLabels {
  Labels labels;
  std::string version;
};

/// The labels are no longer those that the editor saw; nothing was saved.
struct EditConflict {
  VersionedLabels current;
};

using SaveOutcome = std::variant<VersionedLabels, EditConflict>;

/// @throws Error  if the run has no labels, or they cannot be read
VersionedLabels read_versioned_labels(const RunFolder& run);

/// Calls `use` if the labels are still those of that version; meanwhile no other process changes them. @return  whether they are
/// @throws Error  if the file cannot be read; what `use` throws
bool while_unchanged(const RunFolder& run, const std::string& version, const std::function<void()>& use);

/// Changes labels.json, whole or not at all. A lock on the run's folder is held meanwhile, as by `tactile label`, so that no edit
/// is lost; it dies with its process.
/// @param expected  the version that the person saw; nothing: whatever it is
/// @param change    pure; labels to labels. What it throws passes through, and nothing is saved
/// @throws Error  if the labels or the recording cannot be read, or the file cannot be written
SaveOutcome save_change(const RunFolder& run, const std::optional<std::string>& expected,
                        const std::function<Labels(Labels, const RecordingSpan&)>& change);

/// `with_edit`, recorded in the history with the time now.
/// @throws Error  as `with_edit`, or if a flag is lifted without a reason
Labels edited(const Labels& labels, const LabelEdit& edit, const RecordingSpan& recording, const EditNote& note);

SaveOutcome save_edit(const RunFolder& run, const std::optional<std::string>& expected, const LabelEdit& edit,
                      const EditNote& note);
SaveOutcome save_undo(const RunFolder& run, const std::optional<std::string>& expected, std::size_t count = 1);
SaveOutcome save_redo(const RunFolder& run, const std::optional<std::string>& expected, std::size_t count = 1);

/// The user's name on this system; "unknown" if it has none.
std::string system_user();

}  // namespace tactile::labels
