#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "model/small_data.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/model/training/train_model.hpp"
#include "tactile/windows/write_dataset.hpp"

namespace tactile::test {

/// A data folder of small runs, its dataset, and a model of it.
struct Trained {
  TemporaryFolder folder;
  std::filesystem::path file = folder / "data/dataset.h5";
  model::ModelBundle bundle{folder / "models/small"};

  /// @param alter  what becomes of the runs before the dataset is made of them
  explicit Trained(const std::vector<std::string>& objects = {"fan", "usb-hub"}, int runs = 2, unsigned epochs = 4,
                   const std::function<void(const std::filesystem::path& data)>& alter = {}) {
    make_runs(folder / "data", objects, runs);
    if (alter) alter(folder / "data");
    windows::write_dataset(folder / "data", file, {}, 2);
    model::ModelSettings settings;
    settings.training.epochs = epochs;
    model::train_model(windows::Dataset(file), settings, bundle, {.threads = 1});
  }
};

}  // namespace tactile::test
