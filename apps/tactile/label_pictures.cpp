#include "label_pictures.hpp"

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include "tactile/core/error_text.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/labels/label_options.hpp"
#include "tactile/labels/saved_labels.hpp"
#include "tactile/pictures/run_picture.hpp"

namespace tactile::cli {

std::filesystem::path label_picture_of(const RunFolder& run) { return run.folder / "labels.png"; }

void LabelPictures::draw(const alignment::RunSignals& signals) {
  try {
    for (bool is_drawn = false; !is_drawn;) {
      const labels::VersionedLabels now = labels::read_versioned_labels(signals.run);
      WholeFile picture(label_picture_of(signals.run), IfThere::replace);
      pictures::draw_label_picture(pictures::picture_of(signals, now.labels), picture.path());
      is_drawn = labels::while_unchanged(signals.run, now.version, [&] { picture.commit(); });
    }
  } catch (const std::exception& e) {
    note_failure(signals.run, e);
  }
}

void LabelPictures::draw_again(const RunFolder& run) {
  try {
    const labels::Labels now = labels::read_versioned_labels(run).labels;
    draw(alignment::read_run_signals(run, labels::signals_options_of(now.provenance)));
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
  parallel_for(edited.size(), threads, [&](std::size_t i) { pictures.draw_again(edited[i].run); });
  pictures.warn_of_failures();
}

}  // namespace tactile::cli
