#pragma once

#include <filesystem>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "tactile/alignment/run_signals.hpp"
#include "tactile/labels/labels.hpp"

namespace tactile::cli {

/// "DATA/fan/01/labels.png"
std::filesystem::path label_picture_of(const RunFolder& run);

/// Draws labels.png next to the labels of each run, as labels.json is then: if somebody edits it meanwhile, the picture is drawn
/// again, so that no old picture replaces a newer one. A picture that cannot be drawn is left out, because the labels matter
/// more. All of it can be called from several threads.
class LabelPictures {
 public:
  void draw(const alignment::RunSignals& signals);

  /// Reads the run's signals as for its labels first.
  void draw_again(const RunFolder& run);

  void warn_of_failures() const;  ///< names those that were not drawn

 private:
  void note_failure(const RunFolder& run, const std::exception& e);

  std::mutex guard_;
  std::vector<std::string> failures_;
  std::string first_;
};

struct RunAndLabels {
  RunFolder run;
  labels::Labels labels;
};

/// Those of runs whose labels were edited; warns of those that were not drawn.
void draw_label_pictures(std::span<const RunAndLabels> edited, unsigned threads);

}  // namespace tactile::cli
