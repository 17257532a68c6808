#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "command.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/labels/label_history.hpp"

namespace tactile::cli {

/// `tactile label --export` and `--import`.
struct LabelExchangeArguments {
  std::string to;
  std::vector<std::string> from;
  std::string format, origin;

  bool exports() const { return !to.empty(); }
  bool imports() const { return !from.empty(); }
};

/// `compare_truth` and `force` are the command's own options, which cannot be combined with all of these.
void add_label_exchange_options(Command command, LabelExchangeArguments& arguments, const Option compare_truth,
                                const Option force);

/// @throws Error  if --format or --origin is given, which have no meaning without --export or --import
void check_exchange(const LabelExchangeArguments& arguments);

/// Writes the labels of the runs for another tool. Those that have none are labelled before by `label_first`, which returns what
/// went wrong. A run that cannot be exported is left out.
/// @throws Error  if a file is there with other contents and `replace` is not given, or the labels cannot be put into the format;
///                once the other runs are exported, if one was left out
void export_labels(const CommonArguments& common, const LabelExchangeArguments& arguments, const RunsBelow& found, bool replace,
                   const std::function<std::vector<std::string>(std::span<const RunFolder>)>& label_first);

struct ImportArguments {
  labels::EditNote note;
  bool dry_run = false, draw_pictures = true;
};

/// Writes a person's edits from another tool into the labels of the runs, as one edit of each; none after an `Error`. A run whose
/// labels another program changes meanwhile is left out.
/// @throws Error  once the other runs are edited, if one was left out
void import_labels(const CommonArguments& common, const LabelExchangeArguments& arguments, const RunsBelow& found,
                   const ImportArguments& how);

}  // namespace tactile::cli
