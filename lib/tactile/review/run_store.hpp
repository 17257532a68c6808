#pragma once

#include <list>
#include <memory>
#include <mutex>

#include "tactile/review/run_view.hpp"

namespace tactile::review {

/// The runs that are open: the last few that were asked for. A run whose recording has changed, or that got labels, is opened
/// again.
class RunStore {
 public:
  /// @param most  open at once, > 0
  explicit RunStore(Classify classify, std::size_t most = 4) : classify_(std::move(classify)), most_(most) {}

  /// The run, which may still be being read. It stays open while its user has it.
  std::shared_ptr<RunView> open(const RunFolder& run);

 private:
  struct Entry {
    std::string stamp;  ///< of the files that a view reads once
    std::shared_ptr<RunView> view;
  };

  Classify classify_;
  std::size_t most_;
  std::mutex guard_;
  std::list<Entry> entries_;  ///< the last asked first
};

}  // namespace tactile::review
