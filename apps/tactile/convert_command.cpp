#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bag_recording.hpp"
#include "command.hpp"
#include "commands.hpp"
#include "converted_source.hpp"
#include "option_checks.hpp"
#include "quantity_text.hpp"
#include "recording_json.hpp"
#include "suggested_words.hpp"
#include "tactile/bags/bag.hpp"
#include "tactile/conversion/bag_import.hpp"
#include "tactile/conversion/convert.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/recipes/recipe.hpp"
#include "text_table.hpp"

namespace tactile::cli {
namespace {

struct ConvertArguments {
  std::string in, out;
  std::string compression, size, source, crop;
  std::vector<std::string> streams;
  std::string from_us, to_us;
  std::string columns, time_unit;
  conversion::BagImportOptions bag;
  std::string stress;
  std::uint64_t seed = 1;
  bool force = false;
};

std::optional<events::SensorSize> size_in(std::string_view text) {
  const std::size_t cross = text.find('x');
  if (cross == std::string_view::npos) return std::nullopt;
  const auto width = whole_number_in(text.substr(0, cross));
  const auto height = whole_number_in(text.substr(cross + 1));
  if (!width || !height || *width < 1 || *height < 1 || *width > events::most_side || *height > events::most_side)
    return std::nullopt;
  return events::SensorSize{static_cast<int>(*width), static_cast<int>(*height)};
}

std::string check_size(const std::string& text) {
  return size_in(text) ? std::string()
                       : fmt::format("'{}' is not a sensor size; expected WxH, such as 640x480, each from 1 to 32767", text);
}

std::optional<conversion::PixelRegion> pixel_region_in(std::string_view text) {
  const std::size_t first = text.find(','), second = first == text.npos ? text.npos : text.find(',', first + 1);
  if (second == text.npos) return std::nullopt;
  const auto x = whole_number_in(text.substr(0, first)), y = whole_number_in(text.substr(first + 1, second - first - 1));
  const auto size = size_in(text.substr(second + 1));
  if (!x || !y || !size || *x < 0 || *y < 0 || *x > events::most_side || *y > events::most_side) return std::nullopt;
  return conversion::PixelRegion{static_cast<int>(*x), static_cast<int>(*y), size->width, size->height};
}

std::string check_region(const std::string& text) {
  return pixel_region_in(text)
             ? std::string()
             : fmt::format("'{}' is not a region; expected X,Y,WxH, such as 160,120,320x240, from the upper left", text);
}

/// A time of the recording's clock, or with '+' a time after its first element.
struct Moment {
  CameraTime t;
  bool counts_from_first;
};

std::optional<Moment> moment_in(std::string_view text) {
  const bool counts_from_first = text.starts_with('+');
  const auto us = whole_number_in(counts_from_first ? text.substr(1) : text);
  if (!us || (counts_from_first && *us < 0)) return std::nullopt;
  return Moment{camera_time(*us), counts_from_first};
}

std::string check_moment(const std::string& text) {
  return moment_in(text) ? std::string()
                         : fmt::format(
                               "'{}' is not a time; expected whole us of the recording's clock, or after its "
                               "first element, such as +5000",
                               text);
}

conversion::ConvertOptions options_of(const ConvertArguments& args, unsigned threads) {
  conversion::ConvertOptions options;
  if (!args.compression.empty()) options.compression = events::compression_named(args.compression);
  if (const auto from = moment_in(args.from_us)) {
    options.from = from->t;
    options.from_counts_from_first = from->counts_from_first;
  }
  if (const auto to = moment_in(args.to_us)) {
    options.to = to->t;
    options.to_counts_from_first = to->counts_from_first;
  }
  options.streams = args.streams;
  if (!args.crop.empty()) options.crop = pixel_region_in(args.crop);
  if (!args.size.empty()) options.size = size_in(args.size);
  if (!args.source.empty()) options.source = args.source;
  options.csv.columns = args.columns;
  if (!args.time_unit.empty()) options.csv.time_unit = events::time_unit_named(args.time_unit);
  if (!args.stress.empty()) options.recipes = recipes::parse_recipes(args.stress, args.seed);
  options.replace = args.force;
  options.threads = threads;
  return options;
}

void warn(const ConvertArguments& args, const conversion::ConvertSummary& summary) {
  const events::RecordingProblems& problems = summary.problems;
  if (summary.size_guessed) {
    spdlog::info("{}: assuming a sensor of {}x{} pixels, which contains all events; use --size WxH for another size", args.in,
                 summary.size->width, summary.size->height);
  }
  if (summary.time_unit_guessed) {
    spdlog::info("{}: assuming times in {}, because they have a fraction; use --time-unit for another unit", args.in,
                 name_of(*summary.time_unit));
  }
  warn_of_overflows(args.in, summary.overflows);
  const auto from = moment_in(args.from_us);
  if (from && !from->counts_from_first && summary.first_in && from->t < *summary.first_in) {
    spdlog::warn("--from-us {}: cuts nothing, because the first element of {} is at {} us; '+{}' counts from there", args.from_us,
                 args.in, us_of(*summary.first_in), std::max<std::int64_t>(us_of(from->t), 0));
  }
  for (const events::Stream& stream : summary.left_out)
    spdlog::info("{}: stream {} ({}) is left out", args.in, stream.id, stream.name.empty() ? name_of(stream.type) : stream.name);
  const std::uint64_t packets = problems.broken_packets + problems.mismatched_packets + problems.undeclared_packets;
  if (problems.truncated_bytes > 0)
    spdlog::warn("{}: cut off, {} after the last whole packet are lost", args.in, counted(problems.truncated_bytes, "byte"));
  if (problems.skipped_bytes > 0)
    spdlog::warn("{}: damaged, {} between packets are lost", args.in, counted(problems.skipped_bytes, "byte"));
  if (packets > 0) spdlog::warn("{}: {} could not be read, and are not in the output", args.in, counted(packets, "packet"));
  if (problems.out_of_range_events > 0)
    spdlog::warn("{}: {} outside the sensor dropped", args.in, counted(problems.out_of_range_events, "event"));
  if (summary.cropped_events + summary.cropped_frames > 0) {
    spdlog::info("{}: {} and {} outside the crop left out", args.in, counted(summary.cropped_events, "event"),
                 counted(summary.cropped_frames, "frame"));
  }
  if (summary.steps_back > 0)
    spdlog::warn("{}: time steps back {}; times are written unchanged", args.out, counted(summary.steps_back, "time"));
}

nlohmann::json json_of(const ConvertArguments& args, const conversion::ConvertOptions& options,
                       const conversion::ConvertSummary& summary) {
  nlohmann::json streams = nlohmann::json::array();
  for (const conversion::ConvertedStream& stream : summary.streams) {
    streams.push_back({{"id", stream.stream.id},
                       {"type", name_of(stream.stream.type)},
                       {"name", stream.stream.name},
                       {"source", stream.stream.source},
                       {"elements", stream.elements}});
  }
  nlohmann::json stress = nlohmann::json::array();
  for (const recipes::Recipe& recipe : options.recipes) stress.push_back(recipes::json_of(recipe));
  nlohmann::json left_out = nlohmann::json::array();
  for (const events::Stream& stream : summary.left_out) left_out.push_back(stream.id);
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
          {"time_unit", summary.time_unit ? nlohmann::json(name_of(*summary.time_unit)) : nlohmann::json()},
          {"time_overflows", summary.overflows.count},
          {"first_us", summary.first ? nlohmann::json(us_of(*summary.first)) : nlohmann::json()},
          {"last_us", summary.last ? nlohmann::json(us_of(*summary.last)) : nlohmann::json()},
          {"stress", stress},
          {"cropped_events", summary.cropped_events},
          {"cropped_frames", summary.cropped_frames},
          {"steps_back", summary.steps_back},
          {"problems", cli::json_of(summary.problems)}};
}

/// Microseconds, which --from-us and --to-us take, and the date if they count from 1970.
std::string begin_text(CameraTime first) {
  const std::string us = fmt::format("{} us", us_of(first)), moment = moment_text(first);
  return moment == us ? us : fmt::format("{} ({})", moment, us);
}

/// @param format  of the input
std::string text_of(const ConvertArguments& args, const conversion::ConvertOptions& options,
                    const conversion::ConvertSummary& summary, std::string_view format) {
  const auto line = [](const std::string& label, const std::string& text) { return fmt::format("  {:<10}{}\n", label, text); };
  std::string text = args.out + "\n";
  text += line("from", fmt::format("{}, {}, {}", args.in, format, bytes_text(summary.bytes_in)));
  text += line("to", fmt::format("{}{}, {}", name_of(summary.to),
                                 summary.compression ? fmt::format(" ({})", name_of(*summary.compression)) : "",
                                 bytes_text(summary.bytes_out)));
  for (std::size_t i = 0; i < options.recipes.size(); ++i)
    text += line(i == 0 ? "worsened" : "", recipes::text_of(options.recipes[i]));
  if (summary.first) {
    text += line("start", begin_text(*summary.first));
    text += line("duration", duration_text(between(*summary.first, *summary.last)));
  }
  for (std::size_t i = 0; i < summary.streams.size(); ++i) {
    const conversion::ConvertedStream& stream = summary.streams[i];
    text += line(i == 0 ? "streams" : "",
                 fmt::format("{}  {:<8}  {}", stream.stream.id, name_of(stream.stream.type), stream.elements));
  }
  return text;
}

nlohmann::json json_of(const ConvertArguments& args, const conversion::BagImportSummary& summary) {
  nlohmann::json topics = nlohmann::json::array();
  for (const conversion::BagTopic& topic : summary.topics) {
    topics.push_back({{"name", topic.name},
                      {"type", topic.type},
                      {"messages", topic.messages},
                      {"use", topic.use.empty() ? nlohmann::json() : nlohmann::json(topic.use)}});
  }
  const conversion::BagImportDrops& drops = summary.drops;
  const bags::BagProblems& problems = summary.problems;
  return {{"in", args.in},
          {"out", args.out},
          {"run", summary.run.name()},
          {"format", summary.format},
          {"bytes_in", summary.bytes_in},
          {"bytes_out", summary.bytes_out},
          {"topics", topics},
          {"width", summary.size.width},
          {"height", summary.size.height},
          {"events", summary.events},
          {"sorted_events", summary.sorted_events},
          {"imu_samples", summary.imu_samples},
          {"triggers", summary.triggers},
          {"robot_states", summary.robot_states},
          {"has_joints", summary.has_joints},
          {"frames", summary.frames},
          {"first_us", us_of(summary.first)},
          {"last_us", us_of(summary.last)},
          {"dropped",
           {{"events", drops.events},
            {"late_events", drops.late_events},
            {"event_packets", drops.event_packets},
            {"broken_messages", drops.broken_messages},
            {"other_sensor_messages", drops.other_sensor_messages},
            {"robot_states", drops.robot_states},
            {"frames", drops.frames},
            {"imu_samples", drops.imu_samples},
            {"triggers", drops.triggers},
            {"unplaced_events", drops.unplaced_events}}},
          {"problems",
           {{"truncated_bytes", problems.truncated_bytes},
            {"broken_chunks", problems.broken_chunks},
            {"broken_records", problems.broken_records},
            {"unknown_messages", problems.unknown_messages}}}};
}

std::string text_of(const ConvertArguments& args, const conversion::BagImportSummary& summary) {
  const auto line = [](const std::string& label, const std::string& text) { return fmt::format("  {:<10}{}\n", label, text); };
  std::string text = args.out + "\n";
  text += line("from", fmt::format("{}, {}, {}", args.in, summary.format, bytes_text(summary.bytes_in)));
  text += line("to", fmt::format("run {}, {}", summary.run.name(), bytes_text(summary.bytes_out)));
  text += line("start", begin_text(summary.first));
  text += line("duration", duration_text(between(summary.first, summary.last)));
  text += line("events", fmt::format("{}, {}x{}", summary.events, summary.size.width, summary.size.height));
  if (summary.imu_samples > 0) text += line("imu", fmt::format("{}", summary.imu_samples));
  if (summary.triggers > 0) text += line("triggers", fmt::format("{}", summary.triggers));
  if (summary.robot_states > 0)
    text += line("robot", fmt::format("{}, {}", summary.robot_states,
                                      !summary.has_joints ? "pose"
                                      : summary.has_poses ? "pose and joints"
                                                          : "joints"));
  if (summary.frames > 0) text += line("video", counted(summary.frames, "frame"));
  for (const conversion::BagTopic& topic : summary.topics) {
    text += line(&topic == &summary.topics.front() ? "topics" : "",
                 fmt::format("{:<8}{}  {}  {}", topic.use.empty() ? "-" : topic.use, topic.name, topic.type, topic.messages));
  }
  return text;
}

/// Converts a bag to a run folder; the options of recordings do not apply.
void import(const ConvertArguments& args, const CommonArguments& common) {
  if (!args.from_us.empty() || !args.to_us.empty() || !args.crop.empty() || !args.streams.empty() || !args.size.empty() ||
      !args.source.empty() || !args.columns.empty() || !args.time_unit.empty()) {
    throw Error(
        args.in +
        ": a bag is converted completely; expected no --from-us, --to-us, --crop, --stream, --size, --source, --columns and " +
        "--time-unit: " + "the run's events.aedat4 can be cut and cropped afterwards");
  }
  conversion::BagImportOptions options = args.bag;
  if (!args.compression.empty()) options.compression = events::compression_named(args.compression);
  const conversion::BagImportSummary summary = conversion::import_bag(args.in, args.out, options, progress_line(common));
  warn_about_import(args.in, summary);
  print_result(common, json_of(args, summary), text_of(args, summary));
}

/// Whether OUT is a recording, and not a run's folder.
bool is_recording_name(const std::string& out) {
  const std::string extension = conversion::lower_extension(out);
  return extension == ".aedat4" || extension == ".csv" || extension == ".h5" || extension == ".hdf5" || extension == ".npz";
}

void convert(ConvertArguments args, const CommonArguments& common) {
  std::optional<BagRecording> from_bag;
  if (bags::is_bag(args.in)) {
    if (!is_recording_name(args.out)) {
      if (!args.stress.empty())
        throw Error(fmt::format("{}: a run folder from a bag is not worsened; expected .aedat4, .csv, .h5 or .npz with --stress",
                                args.out));
      return import(args, common);
    }
    from_bag.emplace(args.in, args.bag, common);
    args.bag = {};
  }
  if (!from_bag && std::filesystem::is_directory(args.in)) args.in = recording_in(args.in).string();
  const conversion::BagImportOptions& bag = args.bag;
  for (const std::string* topic : {&bag.events_topic, &bag.joints_topic, &bag.pose_topic, &bag.video_topic, &bag.imu_topic}) {
    if (!topic->empty()) throw Error(args.in + ": is not a bag; expected no options for topics");
  }
  const conversion::ConvertOptions options = options_of(args, common.threads);
  conversion::ConvertSummary summary = conversion::convert_recording(from_bag ? from_bag->file() : std::filesystem::path(args.in),
                                                                     args.out, options, progress_line(common));
  std::string format(name_of(summary.from));
  if (from_bag) {  // not of the recording that was made of it on the way
    format = from_bag->summary().format;
    summary.bytes_in = from_bag->summary().bytes_in;
  }
  warn(args, summary);
  print_result(common, json_of(args, options, summary), text_of(args, options, summary, format));
}

void add_topic_options(Command& command, conversion::BagImportOptions& bag) {
  command.add_option("--events-topic", bag.events_topic, "Topic of the events, if a bag has several").type_name("TOPIC");
  command.add_option("--joints-topic", bag.joints_topic, "Topic of the joint states, if a bag has several; none leaves them out")
      .type_name("TOPIC");
  command
      .add_option("--pose-topic", bag.pose_topic,
                  "Topic with the poses of the robot's tool, if a bag has several; none leaves them out")
      .type_name("TOPIC");
  command.add_option("--video-topic", bag.video_topic, "Topic of the video, if a bag has several; none leaves it out")
      .type_name("TOPIC");
  command.add_option("--imu-topic", bag.imu_topic, "Topic of the IMU samples, if a bag has several; none leaves them out")
      .type_name("TOPIC");
}

}  // namespace

void add_convert_command(CLI::App& app) {
  auto args = std::make_shared<ConvertArguments>();
  Command command = add_command(
      app, "convert",
      "Convert recordings between AEDAT4, CSV and HDF5, from RAW and to NPZ; cut and crop them; convert ROS bags to run folders",
      [args](const CommonArguments& common) { convert(*args, common); });
  command
      .add_option("in", args->in,
                  "Input: .aedat4, Prophesee .raw, .csv, .h5, a bag (.bag, .db3, .mcap, or a folder of them), or a run folder")
      .type_name("IN")
      .required();
  command.add_option("out", args->out, "Output: .aedat4, .csv, .h5 or .npz; for a bag also a run folder DATA/OBJECT/NN")
      .type_name("OUT")
      .required();
  command.add_option("--compression", args->compression, "Compression of an AEDAT4 output; default: as the input, or lz4")
      .check(one_of({"none", "lz4", "lz4-high", "zstd", "zstd-high"}));
  command.add_option("--from-us", args->from_us, "Start of the cut [us of camera time, or +US after the first element]")
      .check(Check{check_moment, ""})
      .type_name("US");
  command.add_option("--to-us", args->to_us, "End of the cut; this time itself is left out [as --from-us]")
      .check(Check{check_moment, ""})
      .type_name("US");
  command.add_option("--crop", args->crop, "Keep only these pixels; their upper left corner becomes 0,0 [px]")
      .type_name("X,Y,WxH")
      .check(Check{check_region, ""});
  command
      .add_option("--stream", args->streams, "Keep only this event stream and the other streams of its camera; may be repeated")
      .type_name("ID|SOURCE")
      .repeatable();
  command
      .add_option("--size", args->size,
                  "Sensor size, for CSV and for HDF5 without a size [px]; default for CSV: the smallest common size")
      .type_name("WxH")
      .check(Check{check_size, ""});
  command.add_option("--source", args->source, "Camera name, for CSV and for HDF5 without a name").type_name("NAME");
  command
      .add_option("--columns", args->columns,
                  "Columns of a CSV in their order: t, x, y, p, and - for one to skip; default: by its header row")
      .type_name("NAMES");
  command
      .add_option("--time-unit", args->time_unit,
                  "Unit of a CSV's times; default: as its header row, or us for whole numbers and s for others")
      .check(one_of({"s", "ms", "us", "ns"}));
  command
      .add_option("--stress", args->stress,
                  "Worsen the events: recipes with their severities, such as noise:100,loss:20, or a .json file of them")
      .type_name("RECIPE,...")
      .suggest(recipe_names());
  command.add_option("--seed", args->seed, "Seed of --stress").check(is_seed()).show_default();
  add_topic_options(command, args->bag);
  command.add_flag("--force", args->force, "Replace OUT if it exists, but never IN and never a run");
}

}  // namespace tactile::cli
