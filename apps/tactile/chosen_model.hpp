#pragma once

#include <optional>
#include <string>

#include "tactile/model/bundle/model_bundle.hpp"

namespace tactile::cli {

/// The model that `--model` names: a folder, a network's file, or a name in the folder `models`.
/// @throws Error  if it is named as a network's file and is not there
model::ModelBundle named_model(const std::string& model, const std::string& models);

/// The help of --model.
constexpr const char* default_model_help =
    "Model: a folder, a network's file (.pt, .onnx), or a name in --models; default: the pinned one, else the last one that "
    "'train' made here";

/// A model that a command takes, and why: "the pinned model", "the last one that 'train' made here".
struct ChosenModel {
  model::ModelBundle bundle;
  std::string why;
};

/// The model that a command without --model takes: the pinned one (`tactile models pin`), else the last one that `tactile train`
/// made here. In a folder without a note of the last one it is the newest single-run model, else the newest model.
/// @param dataset  hash of the manifest of the dataset that all but a pinned model must have learned from; null: of any
/// @return         nothing if there is none
std::optional<ChosenModel> model_without_name(const std::string& models, const std::string* dataset = nullptr);

/// The model that `model` names as `named_model` does; if it is empty, `model_without_name`.
/// @throws Error  if there is none
ChosenModel chosen_model(const std::string& model, const std::string& models);

/// The help of --model of a live detector.
constexpr const char* live_model_help =
    "Model: a folder, a network's file (.pt, .onnx), or a name in --models; default: the pinned one, else the last one that "
    "'train' made here if it is of kind stream, else the newest of kind stream, else the last one";

/// The model that a live detector takes: as `chosen_model`, but one of kind stream where there is one, since it has the fewest
/// false alarms: the last one, else the newest with all objects, else the newest. @throws Error  if there is none
ChosenModel live_model(const std::string& model, const std::string& models);

/// Logs the choice and its reason: "detecting with models/th40-single-1, the pinned model"; without a reason if --model named it.
void log_choice(const std::string& doing, const ChosenModel& chosen);

}  // namespace tactile::cli
