#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "command.hpp"
#include "commands.hpp"
#include "quantity_text.hpp"
#include "recording_json.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/events/convert.hpp"
#include "text_table.hpp"

namespace tactile {
namespace {

struct ConvertArguments {
  std::string in, out;
  std::string compression, stream, size, source;
  std::optional<std::int64_t> from_us, to_us;
  bool force = false;
};

std::optional<SensorSize> size_in(std::string_view text) {
  const std::size_t cross = text.find('x');
  if (cross == std::string_view::npos) return std::nullopt;
  const auto width = whole_number_in(text.substr(0, cross));
  const auto height = whole_number_in(text.substr(cross + 1));
  constexpr int most = std::numeric_limits<std::int16_t>::max();
  if (!width || !height || *width < 1 || *height < 1 || *width > most || *height > most) return std::nullopt;
  return SensorSize{static_cast<int>(*width), static_cast<int>(*height)};
}

std::string check_size(const std::string& text) {
  return size_in(text) ? std::string()
                       : fmt::format("'{}' is no sensor size; expected WxH, such as 640x480, each from 1 to 32767", text);
}

std::string_view name_of(RecordingFormat format) { return format == RecordingFormat::csv ? "CSV" : "AEDAT4"; }

ConvertOptions options_of(const ConvertArguments& args, unsigned threads) {
  ConvertOptions options;
  if (!args.compression.empty()) options.compression = compression_named(args.compression);
  if (args.from_us) options.from = camera_time(*args.from_us);
  if (args.to_us) options.to = camera_time(*args.to_us);
  options.stream = args.stream;
  if (!args.size.empty()) options.size = size_in(args.size);
  if (!args.source.empty()) options.source = args.source;
  options.replace = args.force;
  options.threads = threads;
  return options;
}

void warn(const ConvertArguments& args, const ConvertSummary& summary) {
  const RecordingProblems& problems = summary.problems;
  if (summary.size_guessed) {
    spdlog::info("{}: the sensor is taken to have {}x{} pixels, which hold all events; --size WxH says otherwise", args.in,
                 summary.size->width, summary.size->height);
  }
  for (const Stream& stream : summary.left_out)
    spdlog::info("{}: stream {} ({}) is left out", args.in, stream.id, stream.name.empty() ? name_of(stream.type) : stream.name);
  const std::uint64_t packets = problems.broken_packets + problems.mismatched_packets + problems.undeclared_packets;
  if (problems.truncated_bytes > 0)
    spdlog::warn("{}: cut off, {} behind the last whole packet are lost", args.in, counted(problems.truncated_bytes, "byte"));
  if (problems.skipped_bytes > 0)
    spdlog::warn("{}: damaged, {} between packets are lost", args.in, counted(problems.skipped_bytes, "byte"));
  if (packets > 0) spdlog::warn("{}: {} could not be read and left nothing in the output", args.in, counted(packets, "packet"));
  if (problems.out_of_range_events > 0)
    spdlog::warn("{}: {} outside the sensor dropped", args.in, counted(problems.out_of_range_events, "event"));
  if (summary.steps_back > 0)
    spdlog::warn("{}: time steps back {}; written as it is", args.out, counted(summary.steps_back, "time"));
}

nlohmann::json json_of(const ConvertArguments& args, const ConvertSummary& summary) {
  nlohmann::json streams = nlohmann::json::array();
  for (const ConvertedStream& stream : summary.streams) {
    streams.push_back({{"id", stream.stream.id},
                       {"type", name_of(stream.stream.type)},
                       {"name", stream.stream.name},
                       {"source", stream.stream.source},
                       {"elements", stream.elements}});
  }
  nlohmann::json left_out = nlohmann::json::array();
  for (const Stream& stream : summary.left_out) left_out.push_back(stream.id);
  return {{"in", args.in},
          {"out", args.out},
          {"bytes_in", summary.bytes_in},
          {"bytes_out", summary.bytes_out},
          {"compression", summary.compression ? nlohmann::json(name_of(*summary.compression)) : nlohmann::json()},
          {"streams", streams},
          {"left_out", left_out},
          {"width", summary.size ? nlohmann::json(summary.size->width) : nlohmann::json()},
          {"height", summary.size ? nlohmann::json(summary.size->height) : nlohmann::json()},
          {"size_guessed", summary.size_guessed},
          {"first_us", summary.first ? nlohmann::json(us_of(*summary.first)) : nlohmann::json()},
          {"last_us", summary.last ? nlohmann::json(us_of(*summary.last)) : nlohmann::json()},
          {"steps_back", summary.steps_back},
          {"problems", json_of(summary.problems)}};
}

std::string text_of(const ConvertArguments& args, const ConvertSummary& summary) {
  const auto line = [](const std::string& label, const std::string& text) { return fmt::format("  {:<10}{}\n", label, text); };
  std::string text = args.out + "\n";
  text += line("from", fmt::format("{}, {}, {}", args.in, name_of(summary.from), bytes_text(summary.bytes_in)));
  text += line("to", fmt::format("{}{}, {}", name_of(summary.to),
                                 summary.compression ? fmt::format(" ({})", name_of(*summary.compression)) : "",
                                 bytes_text(summary.bytes_out)));
  if (summary.first) {
    text += line("begin", fmt::format("{} ({} us)", moment_text(*summary.first), us_of(*summary.first)));
    text += line("duration", duration_text(between(*summary.first, *summary.last)));
  }
  for (std::size_t i = 0; i < summary.streams.size(); ++i) {
    const ConvertedStream& stream = summary.streams[i];
    text += line(i == 0 ? "streams" : "",
                 fmt::format("{}  {:<8}  {}", stream.stream.id, name_of(stream.stream.type), stream.elements));
  }
  return text;
}

void convert(const ConvertArguments& args, const CommonArguments& common) {
  const ConvertSummary summary = convert_recording(args.in, args.out, options_of(args, common.threads), progress_line(common));
  warn(args, summary);
  print_result(common, json_of(args, summary), text_of(args, summary));
}

}  // namespace

void add_convert_command(CLI::App& app) {
  auto args = std::make_shared<ConvertArguments>();
  CLI::App* command =
      add_command(app, "convert", "Convert recordings between AEDAT4 and CSV, compress them anew, cut them by time",
                  [args](const CommonArguments& common) { convert(*args, common); });
  command->add_option("in", args->in, "Recording to read: .aedat4 or .csv")->type_name("IN")->required();
  command->add_option("out", args->out, "Recording to write: .aedat4 or .csv")->type_name("OUT")->required();
  command->add_option("--compression", args->compression, "Of an AEDAT4 output [the input's; lz4 from CSV]")
      ->check(CLI::IsMember({"none", "lz4", "lz4-high", "zstd", "zstd-high"}));
  command->add_option("--from-us", args->from_us, "Leave out what is earlier [us of camera time]")->type_name("US");
  command->add_option("--to-us", args->to_us, "Leave out what is at this time or later [us of camera time]")->type_name("US");
  command->add_option("--stream", args->stream, "Keep this event stream, by id or source, and the rest of its camera's")
      ->type_name("ID|SOURCE");
  command->add_option("--size", args->size, "Sensor of a CSV's events [px] [the smallest usual one that holds them]")
      ->type_name("WxH")
      ->check(CLI::Validator(check_size, ""));
  command->add_option("--source", args->source, "Camera to name for a CSV's events [csv]")->type_name("NAME");
  command->add_flag("--force", args->force, "Replace OUT if it exists; never IN");
}

}  // namespace tactile
