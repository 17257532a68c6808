#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "command.hpp"
#include "commands.hpp"
#include "option_checks.hpp"
#include "rendering_arguments.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/labels/labels.hpp"
#include "tactile/report/contact_sheet.hpp"
#include "tactile/windows/sample.hpp"

namespace tactile {
namespace {

namespace fs = std::filesystem;

constexpr int columns = 6;
constexpr std::size_t most_intervals = 12;
constexpr std::array<std::chrono::milliseconds, columns> around_onset{-20ms, 10ms, 30ms, 60ms, 150ms, 400ms};

struct ViewArguments {
  std::string what;
  std::string out;
  std::string stream;
  double history_ms = 40;
  RenderingArguments rendering;
  std::optional<int> tiles;
};

/// Ticks to show under one title.
struct TickGroup {
  std::string title;
  std::vector<CameraTime> ticks;
  std::optional<CameraTime> onset;
};

double ms_between(CameraTime begin, CameraTime end) { return static_cast<double>(between(begin, end).count()) / 1000; }

/// `count` ticks from the first to the last, evenly spaced.
TickGroup evenly_spaced(const TickRange& range, std::int64_t count) {
  TickGroup group;
  count = std::min(count, range.count);
  for (std::int64_t i = 0; i < count; ++i) {
    const double share = count == 1 ? 0.0 : static_cast<double>(i) / static_cast<double>(count - 1);
    group.ticks.push_back(range.at(std::llround(share * static_cast<double>(range.count - 1))));
  }
  return group;
}

std::vector<TickGroup> around_onsets(const TickRange& range, const std::vector<LabelledInterval>& intervals,
                                     CameraTime first_event) {
  std::vector<TickGroup> groups;
  for (std::size_t i = 0; i < std::min(intervals.size(), most_intervals); ++i) {
    const TouchInterval interval = intervals[i].interval();
    TickGroup group{.title = fmt::format("{}: onset {:.1f} ms, end {:.1f} ms", name_of(interval.touch),
                                         ms_between(first_event, interval.start), ms_between(first_event, interval.end)),
                    .ticks = {},
                    .onset = interval.start};
    for (const auto offset : around_onset) {
      const CameraTime t = first_tick_from(after(interval.start, offset), range.tick);
      if (t >= range.first && t <= range.at(range.count - 1)) group.ticks.push_back(t);
    }
    if (!group.ticks.empty()) groups.push_back(std::move(group));
  }
  return groups;
}

std::optional<Touch> label_at(const std::optional<Labels>& labels, CameraTime t) {
  if (!labels) return std::nullopt;
  for (const LabelledInterval& interval : labels->intervals) {
    if (interval.interval().contains(t)) return interval.touch;
  }
  return Touch::none;
}

/// What all but a hundredth of the pixels that are not black stay below, so that a few hot ones do not darken the rest.
int bright_value(const std::vector<SheetGroup>& sheet) {
  std::vector<std::uint8_t> values;
  for (const SheetGroup& group : sheet) {
    for (const SheetTile& tile : group.tiles)
      std::copy_if(tile.heatmap.begin<std::uint8_t>(), tile.heatmap.end<std::uint8_t>(), std::back_inserter(values),
                   [](std::uint8_t value) { return value > 0; });
  }
  if (values.empty()) return 255;
  const auto place = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) * 99 / 100);
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

/// Whether the run that holds the recording was simulated; a recording that is no run's never was, as far as anybody can tell.
bool is_simulated(const RunFolder& run, const fs::path& recording) {
  return recording.filename() == run.events().filename() && fs::exists(run.info()) && read_run_info(run).simulated;
}

void view(const ViewArguments& args, const CommonArguments& common) {
  if (args.out.empty()) throw CLI::RequiredError("--out");
  if (fs::path(args.out).extension() != ".png")
    throw Error(args.out + ": the picture is a PNG; expected a name that ends in .png");
  const bool is_run = fs::is_directory(args.what);
  const std::optional<RunFolder> run = is_run ? std::optional(run_folder_at(args.what)) : std::nullopt;
  RecordingReader recording(is_run ? recording_in(args.what) : fs::path(args.what));
  const Stream& stream = event_stream(recording, args.stream);
  const std::string name = run ? run->name() : recording.file().filename().string();
  if (!stream.size)
    throw Error(fmt::format("{}: stream {} declares no size; expected its sensor's", recording.file().string(), stream.id));
  const SensorSize sensor = *stream.size;
  const HeatmapOptions options = heatmap_options(args.history_ms, args.rendering);
  const SensorSize size = HeatmapRenderer(sensor, options).size();

  std::optional<CameraTime> first, last;
  std::uint64_t events = 0;
  for_all_events(recording, stream.id, [&](std::span<const Event> packet) {
    stop_if_interrupted();
    if (packet.empty()) return;
    if (!first) first = packet.front().t;
    last = packet.back().t;
    events += packet.size();
  });
  if (!first) throw Error(recording.file().string() + ": holds no event; expected a recording with events");
  const TickRange range = full_ticks(*first, *last, options.history, options.tick);
  if (range.count == 0) {
    throw Error(
        fmt::format("{}: {:.1f} ms long, which holds no full history of {} ms; expected a longer recording or a smaller --th",
                    recording.file().string(), ms_between(*first, *last), args.history_ms));
  }
  const std::optional<Labels> labels =
      run && fs::exists(run->labels()) ? std::optional(read_labels(run->labels())) : std::nullopt;
  std::vector<TickGroup> groups;
  if (labels) groups = around_onsets(range, labels->intervals, *first);
  const bool shows_onsets = !groups.empty();
  if (shows_onsets && args.tiles) {
    throw Error(fmt::format("--tiles: {} is labelled and shown around its onsets; expected no --tiles, or {}", args.what,
                            run->events().string()));
  }
  if (!shows_onsets) groups.push_back(evenly_spaced(range, args.tiles.value_or(24)));

  nlohmann::json tiles = nlohmann::json::array();
  std::vector<SheetGroup> sheet;
  for (const TickGroup& group : groups) {
    sheet.push_back({.title = group.title, .tiles = {}});
    for (const CameraTime t : group.ticks) {
      stop_if_interrupted();
      HeatmapRenderer renderer(sensor, options);
      for_events_between(recording, stream.id, before(t, options.history), t,
                         [&](std::span<const Event> part) { renderer.add(part); });
      renderer.move_to(t);
      cv::Mat heatmap(renderer.size().height, renderer.size().width, CV_8UC1);
      renderer.render(std::span(heatmap.data, heatmap.total()));
      const std::optional<Touch> touch = label_at(labels, t);
      SheetTile tile{.heatmap = heatmap,
                     .caption = fmt::format("{:.1f} ms", ms_between(*first, t)),
                     .second_caption = fmt::format("{} events", renderer.events()),
                     .touch = touch};
      if (group.onset) tile.caption += fmt::format(" ({:+.1f} ms)", ms_between(*group.onset, t));
      if (touch) tile.second_caption = fmt::format("{}, {}", name_of(*touch), tile.second_caption);
      sheet.back().tiles.push_back(std::move(tile));
      tiles.push_back({{"t_us", us_of(t)},
                       {"since_first_event_ms", ms_between(*first, t)},
                       {"events", renderer.events()},
                       {"label", touch ? nlohmann::json(name_of(*touch)) : nlohmann::json(nullptr)}});
    }
  }

  const bool simulated = is_simulated(run ? *run : run_folder_at(fs::absolute(recording.file()).parent_path()), recording.file());
  const int brightest = bright_value(sheet);
  SheetOptions layout{.header = {}, .columns = columns, .brightest = brightest};
  layout.header.push_back(fmt::format("{}{}: heatmaps of t_h {} ms, {}x{}, denoise {}, resize {}", name,
                                      simulated ? " (simulated)" : "", args.history_ms, size.width,
                                      size.height, args.rendering.denoise, args.rendering.resize));
  layout.header.push_back(fmt::format("{}, {}x{} px: {} events in {:.1f} ms", stream.source.empty() ? "events" : stream.source,
                                      sensor.width, sensor.height, events, ms_between(*first, *last)));
  layout.header.push_back(fmt::format("colours from 0 to {} of 255, brighter ones alike; times from the first event{}", brightest,
                                      shows_onsets ? " (and from the onset)" : ""));
  if (shows_onsets && labels->intervals.size() > groups.size()) {
    layout.header.push_back(fmt::format("{} of {} intervals are shown", groups.size(), labels->intervals.size()));
  }
  write_png(args.out, contact_sheet(sheet, layout));
  print_result(common,
               {{"out", args.out},
                {"file", recording.file().string()},
                {"simulated", simulated},
                {"sensor", {{"width", sensor.width}, {"height", sensor.height}}},
                {"heatmap", {{"width", size.width}, {"height", size.height}}},
                {"settings", options},
                {"brightest", brightest},
                {"tiles", tiles}},
               fmt::format("{}: {} heatmaps of {}\n", args.out, tiles.size(), name));
}

}  // namespace

void add_view_command(CLI::App& app) {
  auto args = std::make_shared<ViewArguments>();
  CLI::App* command = add_command(app, "view", "Draw a contact sheet of heatmaps along a recording",
                                  [args](const CommonArguments& common) { view(*args, common); });
  command->add_option("what", args->what, "Recording (AEDAT4) or run folder")
      ->type_name("FILE|RUN")
      ->required()
      ->check(CLI::Validator(
          [](std::string& text) {
            return fs::exists(text) ? std::string() : fmt::format("there is no {}; expected a recording or a run's folder", text);
          },
          ""));
  command->add_option("--out", args->out, "Picture to write")->type_name("FILE.png");
  command->add_option("--th", args->history_ms, "History t_h [ms], a whole number of ticks")
      ->check(in_range(0.001, 1e5))
      ->capture_default_str();
  command->add_option("--stream", args->stream, "Event stream, by its id or source, where there is more than one")
      ->type_name("ID|SOURCE");
  command->add_option("--tiles", args->tiles, "Heatmaps on the sheet; not for labelled runs, shown around their onsets")
      ->check(in_range(1, 600))
      ->default_str("24");
  add_rendering_options(*command, args->rendering);
}

}  // namespace tactile
