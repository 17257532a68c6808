#include "tactile/labels/label_options.hpp"

#include <algorithm>
#include <opencv2/core/types.hpp>
#include <vector>

namespace tactile::labels {

nlohmann::json settings_of(const LabelOptions& options) {
  // A long list of one line per setting, in the groups of labels.json: divided, it would no longer show the whole.
  nlohmann::json region;
  if (const auto& r = options.signals.video.region) region = {r->x, r->y, r->width, r->height};
  const alignment::AnchorOptions& anchors = options.clocks.anchors;
  const alignment::ClockFitOptions& fit = options.clocks.fit;
  nlohmann::json settings = {
      {"method", options.method == LabelMethod::model ? "model" : "stages"},
      {"doubt", {{"least_probability", options.doubt.least_probability}, {"widest_onset_ms", options.doubt.widest_onset_ms}}},
      {"rate",
       {{"bin_us", options.signals.rate.bin.count()},
        {"hot_pixel_hz", options.signals.rate.hot_pixel_hz},
        {"flickers", options.signals.rate.flickers}}},
      {"activity",
       {{"smoothing_us", options.signals.activity.smoothing.count()},
        {"enter", options.signals.activity.enter},
        {"leave", options.signals.activity.leave},
        {"merge_us", options.signals.activity.merge.count()},
        {"shortest_us", options.signals.activity.shortest.count()}}},
      {"shortest_gap_us", options.signals.shortest_gap.count()},
      {"video", {{"width", options.signals.video.width}, {"region", region}}},
      {"touches",
       {{"releases", options.touches.releases},
        {"deepens", options.touches.deepens},
        {"like_a_press", options.touches.like_a_press},
        {"shortest_press_us", options.touches.shortest_press.count()},
        {"shortest_slow_press_us", options.touches.shortest_slow_press.count()},
        {"longest_recontact_us", options.touches.longest_recontact.count()}}},
      {"onset",
       {{"before_us", options.onset.before.count()},
        {"first_contact_us", options.onset.first_contact.count()},
        {"rise_us", options.onset.rise.count()},
        {"first_drag_us", options.onset.first_drag.count()},
        {"latency_us", options.onset.latency.count()},
        {"noise_ahead_us", options.onset.noise_ahead.count()},
        {"longest_blind_us", options.onset.longest_blind.count()},
        {"blind_anew_us", options.onset.blind_reset.count()},
        {"press_blind_share", options.onset.press_blind_share},
        {"too_wide_ms", options.onset.too_wide_ms}}},
      {"end",
       {{"still_share", options.end.still_share},
        {"press_still_us", options.end.press_still.count()},
        {"slip_still_us", options.end.slip_still.count()},
        {"rung_out_us", options.end.rung_out.count()},
        {"longest_unseen_us", options.end.longest_unseen.count()},
        {"stick_phase_us", options.end.stick_phase.count()},
        {"least_error_us", options.end.least_error.count()},
        {"too_wide_ms", options.end.too_wide_ms}}},
      {"anchors",
       {{"grid_us", anchors.grid.count()},
        {"ambiguous_below", anchors.ambiguous_below},
        {"least_likeness", anchors.least_likeness},
        {"most_slack_m", anchors.most_slack_m},
        {"stage_delay_us", anchors.stage_delay.count()}}},
      {"clock_fit",
       {{"most_drift_ppm", fit.most_drift_ppm},
        {"usual_drift_ppm", fit.usual_drift_ppm},
        {"drift_needs_anchors", fit.drift_needs_anchors},
        {"drift_needs_span_us", fit.drift_needs_span.count()},
        {"reject_beyond", fit.reject_beyond}}},
      {"video_clock",
       {{"coarse_offset_us",
         options.video_clock.coarse_offset_us ? nlohmann::json(*options.video_clock.coarse_offset_us) : nlohmann::json(nullptr)},
        {"search_us", options.video_clock.search.count()},
        {"least_likeness", options.video_clock.least_likeness},
        {"least_ambiguity", options.video_clock.least_ambiguity},
        {"most_disagreement_us", options.video_clock.most_disagreement_us}}},
      {"longest_disagreement_us", options.longest_disagreement.count()},
      {"latest_slip_us", options.latest_slip.count()},
      {"earliest_slip_us", options.earliest_slip.count()}};
  if (!options.signals.rate.mask.empty()) settings["rate"]["mask"] = options.signals.rate.mask;
  if (!options.signals.robot.columns.empty()) settings["robot_columns"] = options.signals.robot.columns;
  return settings;
}

robot::RobotLogOptions robot_log_options_of(const nlohmann::json& provenance) {
  const nlohmann::json::json_pointer place("/settings/robot_columns");
  const bool is_there = provenance.is_object() && provenance.contains(place) && provenance.at(place).is_string();
  return {.arm = {}, .columns = is_there ? provenance.at(place).get<std::string>() : std::string()};
}

alignment::RunSignalsOptions signals_options_of(const nlohmann::json& provenance) {
  alignment::RunSignalsOptions options;
  options.robot = robot_log_options_of(provenance);
  const auto list_at = [&](const char* path) {
    const nlohmann::json::json_pointer place(path);
    const bool is_there = provenance.is_object() && provenance.contains(place) && provenance.at(place).is_array();
    return is_there ? provenance.at(place) : nlohmann::json::array();
  };
  const auto whole_numbers = [](const nlohmann::json& list, std::size_t count) {
    const bool fits = list.is_array() && list.size() == count &&
                      std::all_of(list.begin(), list.end(), [](const nlohmann::json& n) { return n.is_number_integer(); });
    return fits ? list.get<std::vector<int>>() : std::vector<int>();
  };
  if (const auto r = whole_numbers(list_at("/settings/video/region"), 4); !r.empty())
    options.video.region = cv::Rect(r[0], r[1], r[2], r[3]);
  for (const nlohmann::json& pixel : list_at("/settings/rate/mask")) {
    if (const auto xy = whole_numbers(pixel, 2); !xy.empty()) options.rate.mask.emplace_back(xy[0], xy[1]);
  }
  return options;
}

}  // namespace tactile::labels
