#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "tactile/labels/edit_history.hpp"
#include "tactile/labels/labelled_interval.hpp"

// The parts of labels.json, which its lists and its history share. All readers throw an Error that names `where`.
namespace tactile::labels {

std::optional<CameraTime> time_in(const nlohmann::json& object, const char* key, const std::string& where);
nlohmann::json list_in(const nlohmann::json& object, const char* key, const std::string& where);
TouchInterval stretch_in(const nlohmann::json& object, Touch touch, const std::string& where);

nlohmann::json json_of(const LabelledInterval& interval);
LabelledInterval interval_in(const nlohmann::json& object, const std::string& where);

nlohmann::json json_of(const LabelFlag& flag);
LabelFlag flag_in(const nlohmann::json& object, const std::string& where);

nlohmann::json json_of_rejected(const TouchInterval& rejected);
TouchInterval rejected_in(const nlohmann::json& object, const std::string& where);

/// Without the oldest edits, where all would take more than 3 MiB.
nlohmann::json json_of(const EditHistory& history);
/// @throws Error  also if there are more than `most_history_entries`
EditHistory history_in(const nlohmann::json& object, const std::string& where);

}  // namespace tactile::labels
