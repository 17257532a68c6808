#include "tactile/labels/saved_labels.hpp"

#include <pwd.h>
#include <unistd.h>

#include "tactile/core/error.hpp"
#include "tactile/core/folder_lock.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/utc_time.hpp"

namespace tactile::labels {
namespace {

VersionedLabels read_locked(const RunFolder& run) {
  if (!is_there(run.labels())) throw Error(run.name() + ": has no labels; 'tactile label' makes them");
  return {read_labels(run.labels()), sha256_of_file(run.labels())};
}

}  // namespace

VersionedLabels read_versioned_labels(const RunFolder& run) {
  const FolderLock lock(run.folder);
  return read_locked(run);
}

bool while_unchanged(const RunFolder& run, const std::string& version, const std::function<void()>& use) {
  const FolderLock lock(run.folder);
  if (!is_there(run.labels()) || sha256_of_file(run.labels()) != version) return false;
  use();
  return true;
}

SaveOutcome save_change(const RunFolder& run, const std::optional<std::string>& expected,
                        const std::function<Labels(Labels, const RecordingSpan&)>& change) {
  const RecordingSpan recording = span_of_events(run);
  const FolderLock lock(run.folder);
  VersionedLabels current = read_locked(run);
  if (expected && *expected != current.version) return EditConflict{std::move(current)};
  current.labels = change(std::move(current.labels), recording);
  write_labels(run.labels(), current.labels);
  current.version = sha256_of_file(run.labels());
  return current;
}

Labels edited(const Labels& labels, const LabelEdit& edit, const RecordingSpan& recording, const EditNote& note) {
  if (std::holds_alternative<LiftFlag>(edit) && note.why.empty())
    throw Error("a flag is lifted without a reason; expected why the label is right");
  return recorded(labels, with_edit(labels, edit, recording), note, words_of(edit, labels, recording), now_utc());
}

SaveOutcome save_edit(const RunFolder& run, const std::optional<std::string>& expected, const LabelEdit& edit,
                      const EditNote& note) {
  return save_change(run, expected,
                     [&](const Labels& labels, const RecordingSpan& recording) { return edited(labels, edit, recording, note); });
}

SaveOutcome save_undo(const RunFolder& run, const std::optional<std::string>& expected, std::size_t count) {
  return save_change(run, expected, [&](Labels labels, const RecordingSpan&) { return undone(std::move(labels), count); });
}

SaveOutcome save_redo(const RunFolder& run, const std::optional<std::string>& expected, std::size_t count) {
  return save_change(run, expected, [&](Labels labels, const RecordingSpan&) { return redone(std::move(labels), count); });
}

std::string system_user() {
  const struct passwd* user = ::getpwuid(::geteuid());
  return user != nullptr && user->pw_name != nullptr ? user->pw_name : "unknown";
}

}  // namespace tactile::labels
