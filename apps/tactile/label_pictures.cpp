#include "label_pictures.hpp"

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include "tactile/core/error_text.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/labels/label_options.hpp"
#include "tactile/pictures/run_picture.hpp"

namespace tactile::cli {

std::filesystem::path label_picture_of(const RunFolder& run) { return run.folder / "labels.png"; }

void LabelPictures::draw(const alignment::RunSignals& signals, const labels::Labels& labels) {
  try {
    pictures::draw_label_picture(pictures::picture_of(signals, labels), label_picture_of(signals.run));
  } catch (const std::exception& e) {
    note_failure(signals.run, e);
  }
}

void LabelPictures::draw_again(const RunFolder& run, const labels::Labels& labels) {
  try {
    draw(alignment::read_run_signals(run, labels::signals_options_of(labels.provenance)), labels);
  } catch (const std::exception& e) {
    note_failure(run, e);
  }
}

void LabelPictures::warn_of_failures() const {
  if (failures_.empty()) return;
  spdlog::warn("{} not drawn (--no-pictures leaves them out): {}",
               failures_.size() == 1 ? first_ + "/labels.png was" : fmt::format("{} pictures were", failures_.size()),
               failures_.front());
}

void LabelPictures::note_failure(const RunFolder& run, const std::exception& e) {
  const std::scoped_lock lock(guard_);
  if (failures_.empty()) first_ = run.name();
  failures_.push_back(sentence_of(e));
}

void draw_label_pictures(std::span<const RunAndLabels> edited, unsigned threads) {
  LabelPictures pictures;
  parallel_for(edited.size(), threads, [&](std::size_t i) { pictures.draw_again(edited[i].run, edited[i].labels); });
  pictures.warn_of_failures();
}

}  // namespace tactile::cli
