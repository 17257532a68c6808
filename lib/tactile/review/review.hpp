#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "tactile/core/time.hpp"
#include "tactile/review/page_message.hpp"
#include "tactile/review/run_list.hpp"
#include "tactile/review/run_view.hpp"

namespace tactile::review {

struct ReviewOptions {
  std::string data;                ///< what is reviewed, in words: the folder's name
  std::filesystem::path models;    ///< folder of model bundles; may not exist
  std::filesystem::path studies;   ///< folder of folders with study.json, trade.json, stress.json or eval.json
  std::filesystem::path pieces{};  ///< folder of runs, where recordings that are cut go
  std::string who;                 ///< edits
  microseconds history{40'000};    ///< t_h that the page shows at first
  microseconds tick{2'000};
};

/// What the review has others do.
struct ReviewHelp {
  Classify classify;
  std::function<std::optional<std::string>()> default_model;                 ///< the model's name; nothing if there is none
  std::function<void(const RunFolder&, const labels::Labels&)> draw_labels;  ///< labels.png; called on one thread
};

/// Answers what the page of `tactile review` asks: all paths below /api. Knows no sockets. May be called from several threads.
class Review {
 public:
  /// @throws Error  as `RunList`
  Review(ReviewOptions options, ReviewHelp help, RunList::Find find);
  ~Review();  ///< draws the pictures of labels that still wait

  /// @throws Refusal  if there is no such path, or it is asked for wrongly
  PageResponse answer(const PageRequest& request);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile::review
