#include "tactile/pictures/label_zoom.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "tactile/core/text_lines.hpp"

namespace tactile::pictures {
namespace {

constexpr double zoom_ms = 60;
constexpr double zoom_character = 6.6;  // [px] of the words at the evidence

struct SourceEvidence {
  std::string name;
  std::string_view colour;
  std::optional<CameraTime> at;
  const alignment::FittedClock* clock = nullptr;  ///< that its time was converted by
};

/// The evidence of other sources than the events for an onset.
std::vector<SourceEvidence> evidence_of(const labels::LabelledInterval& interval, const labels::Labels& labels) {
  const labels::Evidence& evidence = interval.evidence;
  const alignment::FittedClock* robot = evidence.robot ? labels.robot_clock_at(*evidence.robot) : nullptr;
  const alignment::FittedClock* video = evidence.video && labels.video_clock ? &*labels.video_clock : nullptr;
  return {{interval.touch == Touch::slip ? "lift start" : "command", label_colours::robot, evidence.robot, robot},
          {"video", label_colours::video, evidence.video, video},
          {"IMU", label_colours::imu, evidence.imu, nullptr}};
}

/// The height of its words in a panel [px].
double height_of(const SourceEvidence& source) { return source.clock == nullptr ? 16 : 24; }

void mark_evidence(LabelScript& script, const SourceEvidence& source, double ms, double row_px, const PlotBox& box) {
  const auto graph_y = [&](double px) { return 1 - px / (box.bottom - box.top); };
  const bool inside = std::abs(ms) <= zoom_ms;
  std::string words = fmt::format("{} {} ms", source.name, signed_ms(ms));
  // On the side away from the onset's line where there is room. The box hides the lines of other sources.
  const double room_ms = (zoom_character * static_cast<double>(characters_in(words)) + 8) * script.pixel();
  double x = ms + 1.2;
  bool to_left = ms < 0 ? ms - room_ms > -zoom_ms : ms + room_ms > zoom_ms;
  if (inside) {
    script.upright(ms, fmt::format("back lc rgb '{}' dt (4,3) lw 1.3", source.colour));
    if (to_left) x = ms - 1.2;
  } else {
    to_left = ms > 0;
    x = to_left ? zoom_ms - 1 : -zoom_ms + 1;
    words = to_left ? words + " →" : "← " + words;
  }
  script.add("set label {} at first {:.9g}, graph {:.6f} {} font ',9' front boxed textcolor rgb '{}'", plot_text(words), x,
             graph_y(row_px), to_left ? "right" : "left", source.colour);
  if (source.clock == nullptr || !inside) return;
  // The uncertainty of its clock.
  const auto offset = static_cast<double>(source.clock->relation.offset_us);
  const auto by_drift = static_cast<double>((source.clock->uncertainty_at(*source.at) - source.clock->uncertainty()).count());
  const double low = ms + 1e-3 * (static_cast<double>(source.clock->offset_low_us) - offset - by_drift);
  const double high = ms + 1e-3 * (static_cast<double>(source.clock->offset_high_us) - offset + by_drift);
  script.add("set arrow from first {:.9g}, graph {:.6f} to first {:.9g}, graph {:.6f} nohead front lc rgb '{}' lw 3",
             std::clamp(low, -zoom_ms, zoom_ms), graph_y(row_px + 11), std::clamp(high, -zoom_ms, zoom_ms), graph_y(row_px + 11),
             source.colour);
}

}  // namespace

std::vector<const labels::LabelledInterval*> onsets_to_enlarge(const labels::Labels& labels) {
  std::vector<const labels::LabelledInterval*> chosen;
  for (const labels::LabelledInterval& interval : labels.intervals) chosen.push_back(&interval);
  const auto index_of = [&](const labels::LabelledInterval* interval) {
    return static_cast<std::size_t>(interval - labels.intervals.data());
  };
  const auto rank = [&](const labels::LabelledInterval* interval) {
    return interval->touch == Touch::slip ? 0 : labels.interval_is_flagged(index_of(interval)) ? 1 : 2;
  };
  std::stable_sort(chosen.begin(), chosen.end(), [&](const auto* a, const auto* b) { return rank(a) < rank(b); });
  chosen.resize(std::min(chosen.size(), most_zooms));
  std::sort(chosen.begin(), chosen.end(), [&](const auto* a, const auto* b) { return index_of(a) < index_of(b); });
  return chosen;
}

void draw_zoom(LabelScript& script, const labels::LabelledInterval& interval, const PlotBox& box, bool is_last) {
  const auto ms_from_onset = [&](CameraTime t) { return 1e-3 * static_cast<double>(between(interval.start.at, t).count()); };
  script.begin_panel(box, -zoom_ms, zoom_ms);
  const double zero_us = static_cast<double>(between(script.picture().rate.begin, interval.start.at).count());
  const auto rate_by = [&](microseconds bin) {
    return script.root_rate(bin, zero_us - 1000 * (zoom_ms + 2), zero_us + 1000 * (zoom_ms + 2), 1000, zero_us);
  };
  const std::vector<PlotPoint> fine = rate_by(script.picture().rate.bin), coarse = rate_by(microseconds(1'000));
  const std::vector<SourceEvidence> evidence = evidence_of(interval, script.picture().labels);
  // Room for what is written over the rate.
  double written_px = 8;
  for (const SourceEvidence& source : evidence) written_px += source.at ? height_of(source) : 0;
  const double highest =
      std::max(highest_of(coarse), 0.8 * highest_of(fine)) / std::max(0.3, 1 - written_px / (box.bottom - box.top));
  script.add("set yrange [0:{:.9g}]", highest);
  script.square_tics(highest);
  script.add("set format x '%g'\nset xtics 20");
  if (is_last)
    script.add("set xlabel 'ms from the onset' textcolor rgb '{}'", figure_colours::ink);
  else
    script.add("unset xlabel");
  script.add("set ylabel 'events per ms' textcolor rgb '{}'", figure_colours::ink);

  const figure_colours::IntervalColours colours = figure_colours::of_interval(interval.touch);
  const auto held = [](double ms) { return std::clamp(ms, -zoom_ms, zoom_ms); };
  script.band(0, held(ms_from_onset(interval.end.at)), colours.area);
  const double low = ms_from_onset(interval.start.low), high = ms_from_onset(interval.start.high);
  script.band(std::min(held(low), -script.pixel() / 2), std::max(held(high), script.pixel() / 2), colours.border);
  script.upright(0, fmt::format("back lc rgb '{}' lw 1.2", colours.strong));
  double row_px = 10;
  for (const SourceEvidence& source : evidence) {
    if (!source.at) continue;
    mark_evidence(script, source, ms_from_onset(*source.at), row_px, box);
    row_px += height_of(source);
  }
  const bool flagged =
      script.picture().labels.interval_is_flagged(static_cast<std::size_t>(&interval - script.picture().labels.intervals.data()));
  script.write(fmt::format("{} at {:.4f} s, 95 %: {} to {} ms{}{}", interval.id, script.seconds_from_begin(interval.start.at),
                           signed_ms(low), signed_ms(high), interval.confirmed ? ", confirmed" : "", flagged ? ", flagged" : ""),
               box.left - 40, box.top - 13, "left", colours.strong);
  script.add("plot {} with points pt 7 ps 0.22 lc rgb '#9A9A9A' notitle, {} with histeps lc rgb '{}' lw 1.1 notitle",
             script.table(fine), script.table(coarse), figure_colours::ink);
}

}  // namespace tactile::pictures
