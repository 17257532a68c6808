#include "tactile/review/label_cache.hpp"

#include <fmt/core.h>
#include <sys/stat.h>

namespace tactile::review {

std::string stamp_of(const std::filesystem::path& file) {
  struct stat found {};
  if (::stat(file.c_str(), &found) != 0) return {};
  return fmt::format("{}.{}.{}.{}", found.st_ino, found.st_size, found.st_mtim.tv_sec, found.st_mtim.tv_nsec);
}

LabelCache::Shared LabelCache::labels_of(const RunFolder& run) {
  // The stamp is taken first: if the file changes now, the next call reads it again.
  const std::string stamp = stamp_of(run.labels());
  if (stamp.empty()) return nullptr;
  {
    const std::scoped_lock lock(guard_);
    const auto found = entries_.find(run.name());
    if (found != entries_.end() && found->second.stamp == stamp) return found->second.labels;
  }
  auto labels = std::make_shared<const labels::VersionedLabels>(labels::read_versioned_labels(run));
  const std::scoped_lock lock(guard_);
  entries_[run.name()] = {stamp, labels};
  return labels;
}

}  // namespace tactile::review
