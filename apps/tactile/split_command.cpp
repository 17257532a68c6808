#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "camera_time.hpp"
#include "command.hpp"
#include "commands.hpp"
#include "converted_source.hpp"
#include "option_checks.hpp"
#include "quantity_text.hpp"
#include "splitting_arguments.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/text_lines.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/splitting/split_proposal.hpp"
#include "tactile/splitting/split_recording.hpp"
#include "tactile/splitting/split_source.hpp"
#include "text_table.hpp"

namespace tactile::cli {
namespace {

using splitting::SeenKind;

struct SplitArguments {
  std::string recording;
  std::vector<std::string> objects;
  std::string first_run;
  SplittingArguments splitting;
  std::vector<double> at;
  double quiet_s = 2.0;
  bool dry_run = false, camera_time = false;
};

std::string seconds_text(microseconds t) { return fmt::format("{:.3f}", 1e-6 * static_cast<double>(t.count())); }

/// @param zero  of the times of start and end
std::string table_of(const splitting::SplitProposal& proposal, const std::vector<std::string>& names, CameraTime zero) {
  std::vector<std::string> header{"run", "start [s]", "end [s]", "length [s]", "events"};
  if (proposal.looked_for_touches) header.insert(header.end(), {"quiet [s]", "press", "slip", "release"});
  std::vector<std::vector<std::string>> rows;
  for (const splitting::ProposedRun& run : splitting::runs_of(proposal)) {
    std::vector<std::string>& row = rows.emplace_back();
    row = {rows.size() <= names.size() ? names[rows.size() - 1] : std::to_string(rows.size()),
           seconds_text(between(zero, run.begin)), seconds_text(between(zero, run.end)),
           seconds_text(between(run.begin, run.end)), std::to_string(run.events)};
    if (!proposal.looked_for_touches) continue;
    row.push_back(run.quiet_before ? seconds_text(*run.quiet_before) : "");
    for (const SeenKind kind : {SeenKind::press, SeenKind::slip, SeenKind::release})
      row.push_back(std::to_string(splitting::count_of(run, kind)));
  }
  return text_table(header, rows);
}

/// What a person needs to choose --quiet-s.
std::string quiet_text(const splitting::SplitProposal& proposal) {
  if (!proposal.looked_for_touches) return {};
  std::string text = fmt::format(
      fmt::runtime(proposal.cuts.empty()
                       ? "One run: no quiet stretch of {:g} s or more, except where an object is held."
                       : "Cut in the middle of each quiet stretch of {:g} s or more, except where an object is held."),
      1e-6 * static_cast<double>(proposal.quiet_needed.count()));
  if (proposal.quiet_per_s) text += fmt::format(" The skin gives {} while nothing moves.", rate_text(*proposal.quiet_per_s));
  if (!proposal.cuts.empty()) text += " Column 'quiet': without a touch before the run's first one.";
  if (const auto within = splitting::longest_quiet_within(proposal))
    text += fmt::format(" The longest quiet stretch inside a run has {} s.", seconds_text(*within));
  if (proposal.touches.empty()) text += " No touch was found.";
  return wrapped(text) + "\n";
}

/// Runs with less than one would expect; a person should look at them.
void warn_about(const splitting::SplitProposal& proposal, const std::string& recording) {
  if (!proposal.looked_for_touches) return;
  std::string which;
  std::size_t number = 0, count = 0;
  for (const splitting::ProposedRun& run : splitting::runs_of(proposal)) {
    ++number;
    if (splitting::count_of(run, SeenKind::press) > 0 && splitting::count_of(run, SeenKind::slip) > 0) continue;
    which += (which.empty() ? "" : ", ") + std::to_string(number);
    ++count;
  }
  if (count == 0) return;
  spdlog::warn(
      "{}: {} of {} without a press or without a slip: {}. If each should have both, compare --quiet-s with the column "
      "'quiet', or give the cuts by --at",
      recording, count, counted(number, "run"), which);
}

splitting::SplitProposal proposal_of(const SplitArguments& args, const splitting::SplitSource& source,
                                     events::RecordingReader& recording, const CommonArguments& common) {
  const auto us_in = [](double seconds) { return microseconds{std::llround(1e6 * seconds)}; };
  splitting::ProposeOptions options;
  options.stream = args.splitting.stream;
  options.course.quiet = us_in(args.quiet_s);
  if (args.at.empty()) return splitting::propose_runs(source, recording, options, progress_line(common));
  std::vector<microseconds> cuts;
  for (const double at : args.at) cuts.push_back(us_in(at));
  return splitting::proposal_with(source, recording, cuts, options, progress_line(common));
}

std::string result_text(const SplitArguments& args, const splitting::SplitProposal& proposal,
                        const splitting::SplitResult& result) {
  std::vector<std::string> names;
  std::uint64_t copied = 0, encoded = 0, bytes = 0;
  std::size_t kept = 0;
  for (const splitting::SplitRun& run : result.runs) {
    names.push_back(run.run.name());
    copied += run.packets_copied;
    encoded += run.packets_encoded;
    bytes += run.bytes;
    kept += run.is_kept ? 1 : 0;
  }
  std::string text = table_of(proposal, names, zero_of_times(args.camera_time, proposal.first)) + "\n" + quiet_text(proposal);
  const std::string made = kept == result.runs.size() ? "all exist already, and were kept"
                           : kept > 0                 ? fmt::format("{} existed already", kept)
                                                      : "all new";
  text += wrapped(fmt::format("{}: {}, {}, session {}, {}", args.splitting.data, counted(result.runs.size(), "run"), made,
                              result.session, bytes_text(bytes))) +
          "\n";
  if (copied + encoded > 0) text += fmt::format("packets: {} copied as they are, {} encoded again\n", copied, encoded);
  const auto add_device = [&](const char* name, const std::string& how,
                              std::optional<std::uint64_t> splitting::SplitRun::*count) {
    if (how.empty()) return;
    const auto without = std::count_if(result.runs.begin(), result.runs.end(),
                                       [&](const splitting::SplitRun& run) { return run.*count == std::uint64_t{0}; });
    text +=
        wrapped(fmt::format("{}: {}{}", name, how,
                            without > 0 ? fmt::format("; {} without", counted(static_cast<std::uint64_t>(without), "run")) : ""),
                2) +
        "\n";
  };
  add_device("robot log", result.robot, &splitting::SplitRun::robot_rows);
  add_device("film", result.film, &splitting::SplitRun::frames);
  return text;
}

void split(const SplitArguments& args, const CommonArguments& common) {
  std::optional<ConvertedSource> converted;
  if (needs_conversion(args.recording)) converted.emplace(args.recording, args.splitting.data, common);
  splitting::SplitSource source = converted ? converted->source() : splitting::split_source_at(args.recording);
  set_devices(source, args.splitting);
  events::RecordingReader recording(source.recording, common.threads);
  const splitting::SplitProposal proposal = proposal_of(args, source, recording, common);
  warn_about(proposal, args.recording);

  nlohmann::json json = {{"recording", args.recording}, {"proposal", splitting::json_of(proposal)}, {"result", nullptr}};
  if (args.dry_run) {
    const CameraTime zero = zero_of_times(args.camera_time, proposal.first);
    print_result(common, json, table_of(proposal, {}, zero) + "\n" + quiet_text(proposal));
    return;
  }
  splitting::SplitOptions options{.data = args.splitting.data, .objects = args.objects, .session = args.splitting.session};
  if (options.objects.empty())
    options.objects = {source.info && is_object_name(source.info->object) ? source.info->object : "unnamed"};
  if (!args.first_run.empty()) options.first_run = std::stoi(args.first_run);
  const splitting::SplitResult result = splitting::split_recording(source, recording, proposal, options, progress_line(common));
  warn_of_losses(args.recording, result.problems);
  if (!result.warning.empty()) spdlog::warn("{}", result.warning);
  json["result"] = splitting::json_of(result);
  print_result(common, json, result_text(args, proposal, result));
}

}  // namespace

void add_split_command(CLI::App& app) {
  auto args = std::make_shared<SplitArguments>();
  Command command = add_command(app, "split", "Cut a long recording into run folders where the object is let go",
                                [args](const CommonArguments& common) { split(*args, common); });
  command
      .add_option("recording", args->recording,
                  "Recording or run folder, or what 'tactile convert' reads: a bag, .raw, .csv, .h5; it is not changed")
      .type_name("RECORDING")
      .required();
  command
      .add_option("--object", args->objects,
                  "Object of all runs, or of each one; default: that of the recording's run.json, or unnamed")
      .type_name("NAME,...")
      .delimiter(',');
  command.add_option("--first-run", args->first_run, "First number to use; default: after the highest existing run")
      .type_name("NN")
      .check(is_run());
  add_splitting_options(command, args->splitting);
  command.add_option("--at", args->at, "Cut at these times; do not search for cuts [s after the first event]")
      .type_name("S,...")
      .delimiter(',')
      .check(in_range(0.0, 1e6));
  command.add_option("--quiet-s", args->quiet_s, "A run ends where no touch moves for this long [s], unless an object is held")
      .check(in_range(0.05, 3600.0))
      .show_default();
  command.add_flag("--dry-run", args->dry_run, "Print the proposal, and write nothing");
  add_camera_time_option(command, args->camera_time);
}

}  // namespace tactile::cli
