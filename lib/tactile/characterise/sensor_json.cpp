#include "tactile/characterise/sensor_json.hpp"

#include "tactile/core/version.hpp"
#include "tactile/events/readout_json.hpp"

namespace tactile::characterise {
namespace {

using events::json_of;

nlohmann::json json_or_null(const std::optional<Measured>& measured) { return measured ? json_of(*measured) : nlohmann::json(); }

nlohmann::json json_of(const UnusualPixels& unusual) {
  nlohmann::json pixels = nlohmann::json::array();
  for (const UnusualPixel& pixel : unusual.pixels) {
    pixels.push_back({{"kind", name_of(pixel.kind)},
                      {"x", pixel.x},
                      {"y", pixel.y},
                      {"rate_hz", json_of(pixel.rate_hz)},
                      {"on_share", pixel.on_share}});
  }
  return {{"hot", json_of(unusual.hot)},
          {"stuck", json_of(unusual.stuck)},
          {"warm", json_of(unusual.warm)},
          {"lit", unusual.lit},
          {"hot_share_of_events", json_of(unusual.hot_share)},
          {"on_share", json_of(unusual.on_share)},
          {"regularity", json_of(unusual.regularity)},
          {"pixels", pixels}};
}

nlohmann::json json_of(const DeadPixels& dead) {
  nlohmann::json places = nlohmann::json::array();
  for (const auto& [x, y] : dead.places) places.push_back({x, y});
  return {{"count", json_of(dead.count)}, {"silent", dead.silent}, {"expected_silent", dead.expected}, {"pixels", places}};
}

nlohmann::json json_of(const Flicker& flicker) {
  nlohmann::json lines = nlohmann::json::array();
  for (const FlickerLine& line : flicker.lines)
    lines.push_back({{"hz", json_of(line.hz)},
                     {"depth", json_of(line.depth)},
                     {"chance", line.chance},
                     {"lit_pixels", line.lit_pixels},
                     {"only_lit_pixels", line.is_local}});
  const bool searched = flicker.to_hz > flicker.from_hz;
  return {{"searched_hz", searched ? nlohmann::json{flicker.from_hz, flicker.to_hz} : nlohmann::json()},
          {"resolution_hz", flicker.resolution_hz},
          {"lines", lines}};
}

nlohmann::json json_of(const PacketTimes& packets) {
  return {{"packets", packets.packets},
          {"interval_us", json_of(packets.interval_us)},
          {"wait_us", json_of(packets.wait_us)},
          {"longest_us", packets.longest_us},
          {"beginning_before_the_last_ended", packets.back}};
}

nlohmann::json json_of(const LargestCounts& counts) {
  return {{"tick", json_of(counts.tick)}, {"history", json_of(counts.history)}};
}

}  // namespace

std::string_view name_of(UnusualPixel::Kind kind) {
  using Kind = UnusualPixel::Kind;
  return kind == Kind::warm ? "warm" : kind == Kind::hot ? "hot" : kind == Kind::stuck ? "stuck" : "lit";
}

nlohmann::json json_of(const Sensor& sensor) {
  const Background& background = sensor.background;
  nlohmann::json json = {
      {"format", 1},
      {"tactile", version()},
      {"quiet", sensor.quiet},
      {"touched", sensor.touched},
      {"camera", sensor.camera},
      {"sensor", {{"width", sensor.size.width}, {"height", sensor.size.height}}},
      {"seconds", sensor.seconds},
      {"seconds_left_out", sensor.seconds_left_out},
      {"events", sensor.events},
      {"rate_hz", json_of(sensor.rate_hz)},
      {"rate_without_hot_hz", json_of(sensor.rate_without_hot_hz)},
      {"readout", events::json_of(sensor.readout)},
      {"packets", sensor.packets ? json_of(*sensor.packets) : nlohmann::json()},
      {"background",
       {{"on_hz", json_of(background.on_hz)},
        {"off_hz", json_of(background.off_hz)},
        {"spread_decades", json_of(background.spread_decades)},
        {"regularity", json_of(background.regularity)},
        {"on_spread", json_of(background.on_spread)}}},
      {"unusual_pixels", json_of(sensor.unusual)},
      {"dead_pixels", json_of(sensor.dead)},
      {"flicker", json_of(sensor.flicker)},
      {"neighbours", {{"horizontal", json_of(sensor.neighbours.horizontal)}, {"vertical", json_of(sensor.neighbours.vertical)}}},
      {"shortest_interval_us", json_or_null(sensor.shortest_interval_us)},
      {"refractory_us", json_or_null(sensor.refractory_us)},
      {"largest_count", {{"all", json_of(sensor.largest)}, {"ordinary", json_of(sensor.largest_ordinary)}}},
      {"passages", nullptr}};
  if (sensor.passages) {
    const Passages& passages = *sensor.passages;
    json["passages"] = {{"on", {{"events", json_of(passages.on)}, {"passages", passages.on_count}}},
                        {"off", {{"events", json_of(passages.off)}, {"passages", passages.off_count}}}};
  }
  return json;
}

}  // namespace tactile::characterise
