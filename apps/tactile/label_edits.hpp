#pragma once

#include <span>
#include <string>
#include <vector>

#include "command.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/labels/label_history.hpp"

namespace tactile::cli {

/// An edit as it was typed: "--set" and "fan/01:press-1.start=1.2345".
struct TypedEdit {
  std::string option, text;
};

/// A person's edits of labels: `tactile label --confirm`, `--set`, `--add`, `--reject`, `--lift`, `--undo`, `--redo`,
/// `--history`.
struct LabelEditArguments {
  std::vector<TypedEdit> edits;  ///< in the order of the command line
  std::string undo, redo;        ///< how many; empty if the option is missing
  bool history = false;
  bool dry_run = false;  ///< also of --import
  std::string who, why;  ///< also of --import; `who` is the system's user by default

  bool edits_labels() const { return !edits.empty() || !undo.empty() || !redo.empty() || history; }
  labels::EditNote note() const;
};

void add_label_edit_options(Command command, LabelEditArguments& arguments);

/// @param others  options of other work that were given, such as "--import"
/// @throws Error  if options are given that cannot be combined, or have no meaning without another
void check_edits(const LabelEditArguments& arguments, const std::vector<std::string>& others);

/// Makes the edits, the ones of all runs or none. The run of an edit is a path, or a name such as fan/01 below one of `places`.
/// @throws Error  with the option, if an edit cannot be made
void edit_labels(const CommonArguments& common, const LabelEditArguments& arguments, const std::vector<std::string>& places,
                 bool draw_pictures);

/// --undo, --redo and --history. @throws Error  if there is more than one run to undo or redo edits of
void go_through_history(const CommonArguments& common, const LabelEditArguments& arguments, const RunsBelow& found,
                        bool draw_pictures);

}  // namespace tactile::cli
