#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tactile/core/duration_units.hpp"
#include "tactile/core/error.hpp"
#include "tactile/pictures/contact_sheet.hpp"
#include "tactile/pictures/rate_strip.hpp"
#include "view_outputs.hpp"

namespace tactile::cli {
namespace {

constexpr int columns = 6, usual_tiles = 12;
constexpr std::size_t most_intervals = 12;
constexpr std::array<std::chrono::milliseconds, columns> around_onset{-20ms, 10ms, 30ms, 60ms, 150ms, 400ms};

/// Ticks to show under one title.
struct TickGroup {
  std::string title;
  std::vector<CameraTime> ticks;
  std::optional<CameraTime> onset;
};

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

std::vector<TickGroup> around_onsets(const TickRange& range, const ViewedRecording& recording) {
  std::vector<TickGroup> groups;
  for (const TouchInterval& interval : recording.intervals()) {
    if (groups.size() == most_intervals) break;
    TickGroup group{.title = fmt::format("{}: onset {:.1f} ms, end {:.1f} ms", name_of(interval.touch),
                                         recording.ms_from_first(interval.start), recording.ms_from_first(interval.end)),
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

/// A moment as a tile and as JSON.
struct DrawnTick {
  CameraTime t{};
  pictures::SheetTile tile;
  nlohmann::json json;
};

DrawnTick drawn_tick(const pictures::Moment& moment, const ViewedRecording& recording) {
  double most = 0;
  cv::minMaxLoc(moment.counts, nullptr, &most);
  DrawnTick drawn{.t = moment.t, .tile = pictures::sheet_tile(moment), .json = {}};
  pictures::SheetTile& tile = drawn.tile;
  tile.touch = recording.touch_at(moment.t);
  tile.second_caption = fmt::format("{}{} events", tile.touch ? std::string(name_of(*tile.touch)) + ", " : "", moment.events);
  drawn.json = {{"t_us", us_of(moment.t)},
                {"since_first_event_ms", recording.ms_from_first(moment.t)},
                {"events", moment.events},
                {"most_per_pixel", static_cast<std::int64_t>(most)},
                {"label", tile.touch ? nlohmann::json(name_of(*tile.touch)) : nlohmann::json(nullptr)}};
  return drawn;
}

/// The tiles of every group, and the same as JSON.
std::pair<std::vector<pictures::SheetGroup>, nlohmann::json> tiles_of(const std::vector<TickGroup>& groups,
                                                                      const std::vector<DrawnTick>& drawn,
                                                                      const ViewedRecording& recording) {
  nlohmann::json tiles = nlohmann::json::array();
  std::vector<pictures::SheetGroup> sheet;
  for (const TickGroup& group : groups) {
    sheet.push_back({.title = group.title, .tiles = {}});
    for (const CameraTime t : group.ticks) {
      const auto found =
          std::lower_bound(drawn.begin(), drawn.end(), t, [](const DrawnTick& a, CameraTime b) { return a.t < b; });
      pictures::SheetTile tile = found->tile;  // its pictures are shared
      tile.caption = fmt::format("{:.1f} ms", recording.ms_from_first(t));
      if (group.onset) tile.caption += fmt::format(" ({:+.1f} ms)", in_ms(between(*group.onset, t)));
      sheet.back().tiles.push_back(std::move(tile));
      tiles.push_back(found->json);
    }
  }
  return {std::move(sheet), std::move(tiles)};
}

/// The lines over the tiles. @param onsets  shown, 0 where the ticks are evenly spaced
std::vector<std::string> header_of(const ViewedRecording& recording, const heatmaps::HeatmapOptions& options,
                                   std::size_t onsets) {
  const events::SensorSize size = heatmaps::heatmap_size(recording.sensor(), options.factor);
  const nlohmann::json settings = options;
  std::string times = onsets > 0 ? "times from the first event, and from the onset" : "times from the first event";
  if (onsets > 0 && recording.intervals().size() > onsets)
    times += fmt::format("; {} of {} intervals are shown", onsets, recording.intervals().size());
  return {fmt::format("{}: the last {:g} ms before each moment", recording.title(),
                      static_cast<double>(options.history.count()) / 1000),
          fmt::format("{}: {} events in {:.1f} ms", recording.camera(), recording.events(),
                      recording.ms_from_first(recording.last())),
          fmt::format("heatmaps {}x{}, denoise {}, resize {}", size.width, size.height, settings.at("denoise").get<std::string>(),
                      settings.at("resize").get<std::string>()),
          times};
}

}  // namespace

void view_as_sheet(ViewedRecording& recording, const ViewRequest& request, const CommonArguments& common) {
  const TickRange range = recording.ticks_between(request.options, request.from_ms, request.to_ms);
  std::vector<TickGroup> groups;
  if (!request.tiles && !request.from_ms && !request.to_ms) groups = around_onsets(range, recording);
  const std::size_t onsets = groups.size();
  if (onsets == 0) groups.push_back(evenly_spaced(range, request.tiles.value_or(usual_tiles)));

  // Groups of close intervals can share ticks, or have them in another order: each tick is rendered once.
  std::set<CameraTime> wanted;
  for (const TickGroup& group : groups) wanted.insert(group.ticks.begin(), group.ticks.end());
  const std::vector<CameraTime> times(wanted.begin(), wanted.end());
  const ProgressCallback progress = progress_line(common);
  std::vector<DrawnTick> drawn;
  pictures::BrightnessMeter meter;
  pictures::for_moments(recording.reader(), recording.stream_id(), request.options, times, pictures::MomentDetail::all,
                        [&](const pictures::Moment& moment) {
                          report_progress(progress, drawn.size() + 1, times.size(), recording.name());
                          meter.add(moment);
                          drawn.push_back(drawn_tick(moment, recording));
                        });

  const auto [sheet, tiles] = tiles_of(groups, drawn, recording);
  const pictures::SheetOptions layout{
      .header = header_of(recording, request.options, onsets),
      .columns = columns,
      .brightness = meter.result(),
      .banner = {.height = pictures::RateStrip::height, .draw = [&](cv::Mat& picture, const cv::Rect& place) {
                   const pictures::RateStrip strip(recording.first(), recording.last(), recording.first(), place);
                   strip.draw(picture, recording.curve(), recording.intervals());
                   strip.draw_marks(picture, times);
                 }}};
  pictures::write_png(request.out, pictures::contact_sheet(sheet, layout));

  const events::SensorSize size = heatmaps::heatmap_size(recording.sensor(), request.options.factor);
  nlohmann::json result = recording.json();
  result.update({{"out", request.out.string()},
                 {"form", "sheet"},
                 {"heatmap", {{"width", size.width}, {"height", size.height}}},
                 {"settings", request.options},
                 {"brightest", {{"events_per_pixel", layout.brightness.counts}, {"heatmap", layout.brightness.heatmap}}},
                 {"tiles", tiles}});
  print_result(
      common, result,
      fmt::format("{}: {} moment{} of {}{}\n", request.out.string(), tiles.size(), tiles.size() == 1 ? "" : "s", recording.name(),
                  onsets > 0 ? fmt::format(" around {} onset{}", onsets, onsets == 1 ? "" : "s") : ""));
}

}  // namespace tactile::cli
