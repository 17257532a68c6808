#pragma once

#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <thread>

#include "tactile/core/run_folder.hpp"
#include "tactile/labels/labels.hpp"

namespace tactile::review {

/// Draws the pictures of edited labels on a thread, because a person does not wait for them. Of several edits of a run the last
/// is drawn.
class PictureQueue {
 public:
  using Draw = std::function<void(const RunFolder&, const labels::Labels&)>;

  explicit PictureQueue(Draw draw);
  ~PictureQueue();  ///< draws those that wait

  void draw(const RunFolder& run, const labels::Labels& labels);

 private:
  struct Waiting {
    RunFolder run;
    labels::Labels labels;
  };
  void work();

  Draw draw_;
  std::mutex guard_;
  std::condition_variable changed_;
  std::map<std::string, Waiting> waiting_;  ///< by the run's name
  bool ends_ = false;
  std::thread thread_;
};

}  // namespace tactile::review
