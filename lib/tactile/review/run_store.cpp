#include "tactile/review/run_store.hpp"

#include <algorithm>

#include "tactile/core/runs_below.hpp"
#include "tactile/review/label_cache.hpp"

namespace tactile::review {

std::shared_ptr<RunView> RunStore::open(const RunFolder& run) {
  const std::string stamp = stamp_of(run.events()) + "/" + stamp_of(run.robot()) + "/" + stamp_of(run.video()) +
                            (is_there(run.labels()) ? "/labelled" : "");
  std::list<Entry> closed;  // ends after the lock: a view waits for its thread
  const std::scoped_lock lock(guard_);
  const auto found =
      std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) { return entry.view->run().folder == run.folder; });
  if (found != entries_.end() && found->stamp == stamp) {
    entries_.splice(entries_.begin(), entries_, found);
    return entries_.front().view;
  }
  if (found != entries_.end()) closed.splice(closed.begin(), entries_, found);
  while (entries_.size() >= most_) closed.splice(closed.begin(), entries_, std::prev(entries_.end()));
  entries_.push_front({stamp, std::make_shared<RunView>(run, classify_)});
  return entries_.front().view;
}

}  // namespace tactile::review
