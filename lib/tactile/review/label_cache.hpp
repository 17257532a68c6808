#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "tactile/core/run_folder.hpp"
#include "tactile/labels/saved_labels.hpp"

namespace tactile::review {

/// Which file has a name now: another one, or a changed one, has another stamp. Empty if there is none.
std::string stamp_of(const std::filesystem::path& file);

/// The labels of runs as their files have them now; each file is read once, until it changes.
class LabelCache {
 public:
  using Shared = std::shared_ptr<const labels::VersionedLabels>;

  /// Nothing if the run has no labels. @throws Error  if they cannot be read
  Shared labels_of(const RunFolder& run);

 private:
  struct Entry {
    std::string stamp;
    Shared labels;
  };
  std::mutex guard_;
  std::map<std::string, Entry> entries_;  ///< by the run's name
};

}  // namespace tactile::review
