#include "tactile/core/truth.hpp"

#include <algorithm>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"

namespace tactile {
namespace {

nlohmann::json optional_us(const std::optional<CameraTime>& t) { return t ? nlohmann::json(us_of(*t)) : nlohmann::json(nullptr); }

std::optional<CameraTime> optional_time(const nlohmann::json& json, std::string_view key, const std::string& where) {
  if (!json.contains(key) || json.at(std::string(key)).is_null()) return std::nullopt;
  return camera_time(member<std::int64_t>(json, key, where));
}

nlohmann::json json_of(const std::optional<ClockRelation>& clock) { return clock ? nlohmann::json(*clock) : nlohmann::json(); }

std::optional<ClockRelation> clock_in(const nlohmann::json& clocks, std::string_view key, const std::string& where) {
  if (member<nlohmann::json>(clocks, key, where).is_null()) return std::nullopt;
  return member<ClockRelation>(clocks, key, where);
}

TrueInterval interval_from(const nlohmann::json& json, const std::string& where) {
  TrueInterval truth;
  truth.interval.touch = touch_named(member<std::string>(json, "class", where));
  truth.interval.start = camera_time(member<std::int64_t>(json, "start_us", where));
  truth.interval.end = camera_time(member<std::int64_t>(json, "end_us", where));
  if (truth.interval.end <= truth.interval.start)
    throw Error(where + ": an interval ends before it starts; expected start_us < end_us");
  truth.gross = optional_time(json, "gross_us", where);
  truth.first_event = optional_time(json, "first_event_us", where);
  truth.labelled = member<bool>(json, "labelled", where);
  if (json.contains("what")) truth.what = member<std::string>(json, "what", where);
  return truth;
}

std::vector<TruePixel> pixels_in(const nlohmann::json& json, std::string_view key, const std::string& where) {
  std::vector<TruePixel> pixels;
  if (!json.contains(key)) return pixels;
  const auto list = member<nlohmann::json>(json, key, where);
  if (!list.is_array()) throw Error(where + ": '" + std::string(key) + "' is not a list; expected a list of pixels");
  for (const nlohmann::json& pixel : list) {
    pixels.push_back({member<int>(pixel, "x", where), member<int>(pixel, "y", where),
                      pixel.contains("hz") ? member<double>(pixel, "hz", where) : 0.0});
  }
  return pixels;
}

nlohmann::json json_of(const std::vector<TruePixel>& pixels) {
  nlohmann::json json = nlohmann::json::array();
  for (const TruePixel& pixel : pixels) {
    json.push_back({{"x", pixel.x}, {"y", pixel.y}});
    if (pixel.hz > 0) json.back()["hz"] = pixel.hz;
  }
  return json;
}

}  // namespace

Truth read_truth(const std::filesystem::path& file) {
  const nlohmann::json json = read_json(file);
  const std::string where = file.string();
  Truth truth;
  const auto intervals = member<nlohmann::json>(json, "intervals", where);
  if (!intervals.is_array()) throw Error(where + ": 'intervals' is not a list; expected a list of intervals");
  for (const nlohmann::json& interval : intervals) truth.intervals.push_back(interval_from(interval, where));
  const auto starts_before = [](const TrueInterval& a, const TrueInterval& b) { return a.interval.start < b.interval.start; };
  std::stable_sort(truth.intervals.begin(), truth.intervals.end(), starts_before);
  truth.lift_start = optional_time(json, "lift_start_us", where);
  const auto clocks = member<nlohmann::json>(json, "clocks", where);
  truth.robot_clock = clock_in(clocks, "robot", where);
  truth.video_clock = clock_in(clocks, "video", where);
  truth.hot_pixels = pixels_in(json, "hot_pixels", where);
  truth.dead_pixels = pixels_in(json, "dead_pixels", where);
  truth.parameters = json.value("parameters", nlohmann::json::object());
  return truth;
}

void write_truth(const std::filesystem::path& file, const Truth& truth) {
  nlohmann::json intervals = nlohmann::json::array();
  for (const TrueInterval& interval : truth.intervals) {
    intervals.push_back({{"class", name_of(interval.interval.touch)},
                         {"start_us", us_of(interval.interval.start)},
                         {"end_us", us_of(interval.interval.end)},
                         {"gross_us", optional_us(interval.gross)},
                         {"first_event_us", optional_us(interval.first_event)},
                         {"labelled", interval.labelled}});
    if (!interval.what.empty()) intervals.back()["what"] = interval.what;
  }
  write_json(file, {{"intervals", intervals},
                    {"lift_start_us", optional_us(truth.lift_start)},
                    {"clocks", {{"robot", json_of(truth.robot_clock)}, {"video", json_of(truth.video_clock)}}},
                    {"hot_pixels", json_of(truth.hot_pixels)},
                    {"dead_pixels", json_of(truth.dead_pixels)},
                    {"parameters", truth.parameters}});
}

}  // namespace tactile
