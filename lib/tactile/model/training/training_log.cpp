#include "tactile/model/training/training_log.hpp"

#include <utility>

#include "tactile/core/whole_file.hpp"

namespace tactile::model {
namespace {

EventFile::Scalars scalars_of(const EpochResult& epoch) {
  const auto number = [](double value) { return static_cast<float>(value); };
  EventFile::Scalars scalars{{"train/loss", number(epoch.loss)}, {"train/accuracy", number(epoch.accuracy)}};
  if (epoch.validation_loss) scalars.emplace_back("validation/loss", number(*epoch.validation_loss));
  if (epoch.validation_accuracy) scalars.emplace_back("validation/accuracy", number(*epoch.validation_accuracy));
  scalars.emplace_back("learning_rate", number(epoch.learning_rate));
  scalars.emplace_back("gradient_norm", number(epoch.gradient_norm));
  scalars.emplace_back("images_per_s", number(epoch.images_per_s));
  return scalars;
}

}  // namespace

TrainingLog::TrainingLog(std::filesystem::path csv, std::filesystem::path tensorboard)
    : csv_(std::move(csv)), folder_(std::move(tensorboard)) {}

void TrainingLog::begin(const std::vector<EpochResult>& finished) {
  if (!folder_.empty() && has_event_file(folder_)) {
    // What the interrupted training saw after its last saved state is done again.
    events_.emplace(folder_);
    events_->restart_at(static_cast<std::int64_t>(finished.empty() ? 1 : finished.back().epoch + 1));
    seen_ = finished.size();
    if (!finished.empty()) write_whole(csv_, history_csv(finished));
  }
  see(finished);
}

void TrainingLog::see(const std::vector<EpochResult>& finished) {
  if (finished.size() <= seen_) return;
  write_whole(csv_, history_csv(finished));
  if (!folder_.empty() && !events_) events_.emplace(folder_);
  for (; seen_ < finished.size(); ++seen_) {
    if (events_) events_->add(static_cast<std::int64_t>(finished[seen_].epoch), scalars_of(finished[seen_]));
  }
}

}  // namespace tactile::model
