#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "command.hpp"
#include "commands.hpp"
#include "quantity_text.hpp"
#include "recording_json.hpp"
#include "tactile/core/error.hpp"
#include "tactile/events/repair.hpp"
#include "tactile/events/repair_run.hpp"
#include "text_table.hpp"

namespace tactile::cli {
namespace {

struct RepairArguments {
  std::string in, out;
  bool force = false;
};

/// What is damaged and not in the output, one line each; empty if the input is sound.
std::vector<std::string> losses(const events::RepairSummary& summary) {
  const events::RecordingProblems& problems = summary.problems;
  std::vector<std::string> lines;
  if (problems.truncated_bytes > 0)
    lines.push_back(counted(problems.truncated_bytes, "byte") + " after the last whole packet: the recording was cut off");
  if (problems.skipped_bytes > 0) lines.push_back(counted(problems.skipped_bytes, "byte") + " between packets: damaged");
  if (summary.packets_damaged > 0)
    lines.push_back(counted(summary.packets_damaged, "packet") + " changed, according to the checksums next to the recording");
  if (problems.broken_packets > 0) lines.push_back(counted(problems.broken_packets, "packet") + " that could not be decoded");
  if (problems.mismatched_packets > 0)
    lines.push_back(counted(problems.mismatched_packets, "packet") + " of another type than the stream's");
  if (problems.undeclared_packets > 0)
    lines.push_back(counted(problems.undeclared_packets, "packet") + " of a stream that the header does not declare");
  if (problems.missing_packets > 0)
    lines.push_back(fmt::format("{} ({}) of the data table that are missing", counted(problems.missing_packets, "packet"),
                                counted(problems.missing_elements, "element")));
  if (problems.empty_packets > 0) lines.push_back(counted(problems.empty_packets, "packet") + " without contents");
  if (problems.out_of_range_events > 0)
    lines.push_back(counted(problems.out_of_range_events, "event") + " outside the sensor or without polarity");
  for (const auto& [name, bytes] : summary.log_bytes_lost)
    lines.push_back(
        fmt::format("{} of {}: from the first row with a zero byte on, as after a power cut", counted(bytes, "byte"), name));
  return lines;
}

std::string table_text(const events::RepairSummary& summary) {
  if (summary.index == events::PacketIndex::table) return "sound, written again";
  return "rebuilt: " +
         (summary.problems.table.empty() ? std::string("there was none, the recording was not closed") : summary.problems.table);
}

std::uint64_t steps_back_in(const events::RepairSummary& summary) {
  std::uint64_t steps = 0;
  for (const events::RepairedStream& stream : summary.streams) steps += stream.steps_back;
  return steps;
}

nlohmann::json json_of(const RepairArguments& args, const events::RepairSummary& summary) {
  nlohmann::json streams = nlohmann::json::array();
  for (const events::RepairedStream& stream : summary.streams) {
    streams.push_back({{"id", stream.stream.id},
                       {"type", name_of(stream.stream.type)},
                       {"name", stream.stream.name},
                       {"source", stream.stream.source},
                       {"packets_kept", stream.packets_kept},
                       {"packets_lost", stream.packets_lost},
                       {"bytes_lost", stream.bytes_lost},
                       {"elements_kept", stream.elements_kept},
                       {"steps_back", stream.steps_back}});
  }
  const events::RecordingProblems& problems = summary.problems;
  return {{"in", args.in},
          {"out", args.out},
          {"bytes_in", summary.bytes_in},
          {"bytes_out", summary.bytes_out},
          {"bytes_lost", summary.bytes_lost()},
          {"log_bytes_lost", summary.log_bytes_lost},
          {"packets_kept", summary.packets_kept()},
          {"packets_rewritten", summary.packets_rewritten},
          {"packets_lost", summary.packets_lost()},
          {"packets_damaged", summary.packets_damaged},
          {"header_damaged", summary.header_damaged},
          {"table_rebuilt", summary.index == events::PacketIndex::scan},
          {"table_why", problems.table},
          {"steps_back", steps_back_in(summary)},
          {"problems", cli::json_of(problems)},
          {"losses", losses(summary)},
          {"streams", streams}};
}

std::string text_of(const RepairArguments& args, const events::RepairSummary& summary) {
  const auto line = [](const std::string& label, const std::string& text) { return fmt::format("  {:<8}{}\n", label, text); };
  std::string text = args.out + "\n";
  text += line("from", fmt::format("{}, {}", args.in, bytes_text(summary.bytes_in)));
  text += line("kept", fmt::format("{}, {} of them bit for bit", counted(summary.packets_kept(), "packet"),
                                   summary.packets_kept() - summary.packets_rewritten));
  const std::vector<std::string> lost = losses(summary);
  if (lost.empty()) text += line("lost", "nothing");
  for (std::size_t i = 0; i < lost.size(); ++i) text += line(i == 0 ? "lost" : "", lost[i]);
  text += line("table", table_text(summary));
  if (summary.header_damaged) text += line("header", "changed, according to its checksum; used unchanged");
  if (summary.problems.resized_packets > 0)
    text += line("sizes", counted(summary.problems.resized_packets, "packet") + " with a corrected size");
  if (summary.problems.unwrapped_packets > 0)
    text += line("times", counted(summary.problems.unwrapped_packets, "packet") + " moved by 2^32 us into place");
  if (const std::uint64_t steps = steps_back_in(summary); steps > 0) {
    text += line("times", fmt::format("step back {}; unchanged, because the right times are unknown", counted(steps, "time")));
  }
  text += "\n";
  std::vector<std::vector<std::string>> rows;
  for (const events::RepairedStream& stream : summary.streams) {
    rows.push_back({fmt::format("{}  {}", stream.stream.id, name_of(stream.stream.type)), std::to_string(stream.packets_kept),
                    std::to_string(stream.packets_lost), std::to_string(stream.elements_kept),
                    std::to_string(stream.bytes_lost)});
  }
  return text + text_table({"Stream", "packets kept", "packets lost", "elements kept", "bytes lost"}, rows);
}

void repair(const RepairArguments& args, const CommonArguments& common) {
  const bool of_run = std::filesystem::is_directory(args.in);
  if (of_run && args.force) throw Error(args.out + ": --force replaces a recording; expected no --force for a run folder");
  const events::RepairSummary summary =
      of_run ? events::repair_run(run_folder_at(args.in), args.out, common.threads, progress_line(common))
             : events::repair_recording(args.in, args.out, args.force, common.threads, progress_line(common));
  print_result(common, json_of(args, summary), text_of(args, summary));
}

}  // namespace

void add_repair_command(CLI::App& app) {
  auto args = std::make_shared<RepairArguments>();
  Command command = add_command(app, "repair", "Repair a truncated or damaged recording, and report what was lost",
                                [args](const CommonArguments& common) { repair(*args, common); });
  command.add_option("in", args->in, "Damaged recording or run folder; it is not changed").type_name("IN").required();
  command.add_option("out", args->out, "Repaired recording (.aedat4); for a run a new folder DATA/OBJECT/NN")
      .type_name("OUT")
      .required();
  command.add_flag("--force", args->force, "Replace OUT if it exists, but never IN");
}

}  // namespace tactile::cli
