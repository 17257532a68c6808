#include "tactile/labels/label_options.hpp"

#include <algorithm>
#include <opencv2/core/types.hpp>
#include <vector>

namespace tactile::labels {

nlohmann::json settings_of(const LabelOptions& options) {
  nlohmann::json region;
  if (const auto& r = options.signals.video.region) region = {r->x, r->y, r->width, r->height};
  nlohmann::json settings = {
      {"doubt", {{"least_probability", options.doubt.least_probability}, {"widest_onset_ms", options.doubt.widest_onset_ms}}},
      {"rate",
       {{"bin_us", options.signals.rate.bin.count()},
        {"hot_pixel_hz", options.signals.rate.hot_pixel_hz},
        {"flickers", options.signals.rate.flickers}}},
      {"shortest_gap_us", options.signals.shortest_gap.count()},
      {"video", {{"width", options.signals.video.width}, {"region", region}}}};
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
