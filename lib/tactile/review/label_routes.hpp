#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tactile/labels/label_edit.hpp"
#include "tactile/labels/saved_labels.hpp"
#include "tactile/review/page_message.hpp"

namespace tactile::review {

/// An edit as the page sends it: {"kind": "move", "id", "end", "to_us", "within_us", "end_earlier"}, "add" with
/// {"touch", "start_us", "end_us", "within_us", "end_earlier"}, "reject", "class",
/// "confirm", "confirm-run", "lift". Times are in microseconds after the first event.
/// @throws Refusal  (400) if it is no such edit
labels::LabelEdit edit_in(const nlohmann::json& edit, CameraTime first);

/// Saves what the body asks for: {"version", "why", "edit"}. It is saved whole, and only if the labels are still of `version`.
/// @param who  edits
/// @throws Refusal  (400) if the edit cannot be made
labels::SaveOutcome save_asked_edit(const RunFolder& run, const nlohmann::json& body, CameraTime first, const std::string& who);

/// The same of {"version", "count"}. @param is_undo  else redo
labels::SaveOutcome save_asked_step(const RunFolder& run, const nlohmann::json& body, bool is_undo);

}  // namespace tactile::review
