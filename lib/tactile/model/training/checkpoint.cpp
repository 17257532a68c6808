#include "tactile/model/training/checkpoint.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/make_folders.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::model {
namespace {

namespace fs = std::filesystem;

constexpr const char* format_name = "tactile training 1";

fs::path last_file(const fs::path& folder) { return folder / "last.safetensors"; }

nlohmann::json state_json(const TrainingState& state) {
  nlohmann::json json = {{"epoch", state.epoch},
                         {"done", state.done},
                         {"loss", state.loss},
                         {"weight", state.weight},
                         {"correct", state.correct},
                         {"gradient_norm", state.gradient_norm},
                         {"epoch_seconds", state.epoch_seconds},
                         {"history", state.history},
                         {"seconds", state.seconds},
                         {"step", state.optimizer.step},
                         {"best", nullptr}};
  if (state.best) json["best"] = {{"epoch", state.best->epoch}, {"loss", state.best->loss}};
  return json;
}

TrainingState state_from(const nlohmann::json& json, const std::string& where) {
  TrainingState state;
  state.epoch = member<unsigned>(json, "epoch", where);
  state.done = member<std::uint64_t>(json, "done", where);
  state.loss = member<double>(json, "loss", where);
  state.weight = member<double>(json, "weight", where);
  state.correct = member<std::uint64_t>(json, "correct", where);
  state.gradient_norm = member<double>(json, "gradient_norm", where);
  state.epoch_seconds = member<double>(json, "epoch_seconds", where);
  state.history = member<std::vector<EpochResult>>(json, "history", where);
  state.seconds = member<double>(json, "seconds", where);
  state.optimizer.step = member<std::int64_t>(json, "step", where);
  return state;
}

nlohmann::json parsed(const std::map<std::string, std::string>& metadata, const std::string& key, const std::string& where) {
  const auto found = metadata.find(key);
  const auto format = metadata.find("format");
  if (format == metadata.end() || format->second != format_name || found == metadata.end())
    throw Error(where + ": is not the state of a training; remove the folder to start again");
  try {
    return nlohmann::json::parse(found->second);
  } catch (const nlohmann::json::exception&) {
    throw Error(where + ": its " + key + " is not JSON; expected a state saved by 'tactile train'");
  }
}

}  // namespace

CheckpointFolder::CheckpointFolder(fs::path folder) : folder_(std::move(folder)) {
  make_folders(folder_);
  lock_ = ::open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  // Some network disks cannot lock folders. Then another process cannot be detected.
  const bool is_taken = lock_ >= 0 && ::flock(lock_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  if (!is_taken) return;
  ::close(lock_);
  throw Error(folder_.string() + ": another process is training this model; wait for its end, or use another --name");
}

CheckpointFolder::~CheckpointFolder() {
  std::error_code ignored;
  fs::remove(folder_, ignored);  // if nothing was saved
  if (lock_ >= 0) ::close(lock_);
  remove_empty_made_folders(folder_.parent_path());
}

fs::path CheckpointFolder::beside(const fs::path& bundle) { return bundle.string() + ".training"; }

bool CheckpointFolder::holds_state(const fs::path& folder) { return fs::exists(last_file(folder)); }

fs::path CheckpointFolder::best_weights(const fs::path& folder, unsigned epoch) {
  return folder / fmt::format("best-{:04}.safetensors", epoch);
}

void CheckpointFolder::save(const nlohmann::json& task, const TrainingState& state) {
  if (state.best && !fs::exists(best_weights(folder_, state.best->epoch))) {
    write_weights(best_weights(folder_, state.best->epoch), state.best->weights,
                  {{"epoch", std::to_string(state.best->epoch)}, {"loss", fmt::format("{}", state.best->loss)}});
  }
  Weights all = state.weights;
  all.insert(all.end(), state.optimizer.moments.begin(), state.optimizer.moments.end());
  write_weights(last_file(folder_), all, {{"format", format_name}, {"task", task.dump()}, {"state", state_json(state).dump()}});

  const std::string kept = state.best ? best_weights(folder_, state.best->epoch).filename().string() : "";
  for (const auto& entry : fs::directory_iterator(folder_)) {
    const std::string name = entry.path().filename().string();
    std::error_code ignored;
    if (name.starts_with("best-") && name != kept) fs::remove(entry.path(), ignored);
  }
}

std::optional<TrainingState> CheckpointFolder::load(const nlohmann::json& task, const LeNetLayers& layers,
                                                    OptimizerKind optimizer) const {
  const fs::path file = last_file(folder_);
  if (!fs::exists(file)) return std::nullopt;
  const std::string where = file.string();
  const auto metadata = read_metadata(file);
  if (const nlohmann::json begun = parsed(metadata, "task", where); begun != task) {
    throw Error(
        fmt::format("{}: belongs to a training with other settings or another dataset ({}); expected the same ones, "
                    "or --force to start again",
                    folder_.string(), differences(begun, task)));
  }
  const nlohmann::json json = parsed(metadata, "state", where);
  TrainingState state = state_from(json, where);
  const auto parameters = layers.parameters();
  auto shapes = parameters;
  const auto moments = moment_shapes(optimizer, parameters);
  shapes.insert(shapes.end(), moments.begin(), moments.end());
  Weights all = read_weights(file, shapes);
  const auto first_moment = all.begin() + static_cast<std::ptrdiff_t>(parameters.size());
  state.optimizer.moments.assign(std::make_move_iterator(first_moment), std::make_move_iterator(all.end()));
  all.erase(first_moment, all.end());
  state.weights = std::move(all);
  if (const auto best = member<nlohmann::json>(json, "best", where); !best.is_null()) {
    const auto epoch = member<unsigned>(best, "epoch", where);
    state.best = BestEpoch{epoch, member<double>(best, "loss", where), read_weights(best_weights(folder_, epoch), parameters)};
  }
  return state;
}

void CheckpointFolder::clear() {
  std::error_code failed;
  fs::remove(last_file(folder_), failed);  // first: it refers to the other files
  for (const auto& entry : fs::directory_iterator(folder_, failed)) fs::remove_all(entry.path(), failed);
}

void CheckpointFolder::remove() {
  clear();
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

std::optional<nlohmann::json> task_of_checkpoint(const fs::path& folder) {
  if (!CheckpointFolder::holds_state(folder)) return std::nullopt;
  return parsed(read_metadata(last_file(folder)), "task", last_file(folder).string());
}

}  // namespace tactile::model
