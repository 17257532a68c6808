#pragma once

#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/core/time.hpp"
#include "tactile/events/event.hpp"
#include "tactile/simulation/skin.hpp"

namespace tactile::simulation {

/// Slow change of the light: 1 + amplitude (sin(2 pi t / period_s + phase_rad) - sin phase_rad), t from the first read-out.
struct LightDrift {
  double amplitude = 0;
  double period_s = 10;
  double phase_rad = 0;

  double at(double t_s) const {
    return 1.0 + amplitude * (std::sin(2.0 * std::numbers::pi * t_s / period_s + phase_rad) - std::sin(phase_rad));
  }
};

/// The camera's pixels and the light. Thresholds are in ln of the intensity. Intensities are reflectances under constant light,
/// so 1 is white paper. The values here are those of the preset `quiet`; configs/cameras.json has all presets, and
/// configs/README.md the source of each number.
struct EventCameraOptions {
  std::string preset = "quiet";
  events::SensorSize size{640, 480};
  double px_per_mm = 0;   ///< 0: the whole skin fits into the image; see view_of
  double shift_x_mm = 0;  ///< of the skin against the middle of the image
  double shift_y_mm = 0;
  double rotation_rad = 0;  ///< of the skin in the image, clockwise

  double readout_us = 200;        ///< from one read-out to the next
  double scan_us_per_column = 0;  ///< see ReadoutClock
  double scan_us_per_row = 0;
  double wander_us = 0;
  double wander_s = 0.3;
  double jitter_us = 0;
  double readout_events_per_s = 0;
  int readout_limit = 28'000;  ///< events of one read-out that reach the host: 140 Mev/s at 5000 read-outs/s, as measured

  double threshold = 0.25;        ///< mean over the pixels
  double threshold_sigma = 0.03;  ///< between pixels
  double threshold_floor = 0.01;  ///< no pixel is more sensitive than this
  double residual = 1.0;          ///< largest error of a pixel's memory at the start, as a share of its threshold
  /// Time in reset after an event. It is at most a read-out, because hot pixels of this kind of sensor reach one event per
  /// read-out: the read-out itself is the dead time. v2e's 500 us belongs to another sensor.
  microseconds refractory{200};
  double bandwidth_hz = 0;  ///< of a pixel at intensity 1; see EventCamera. 0: no limit
  double bandwidth_floor = 0.1;

  double background_hz = 0;  ///< mean over the pixels, both polarities; see BackgroundNoise
  double background_spread_decades = 0;
  double background_regularity = 1;
  double background_on_share = 0.5;
  double background_on_spread = 0;
  double leak_hz = 0.02;             ///< ON events without cause, mean per pixel
  double leak_spread_decades = 0.1;  ///< of that rate between pixels, standard deviation of its log10
  double shot_hz = 0.06;             ///< ON and OFF equally, in the dark; 1/4 of it at white

  int hot_pixels = 24;  ///< pixels that fire by themselves
  /// Quantiles of their rates, from the least to the most at equal steps, log-linear between them.
  std::vector<double> hot_hz{100.0, 2500.0};
  std::vector<double> hot_on_shares{0.7};  ///< quantiles of a hot pixel's share of ON events, linear between them
  double hot_regularity = 0.5;             ///< share of an interval that is fixed; the rest is exponential
  double hot_turnover = 0.05;              ///< chance that another pixel replaces a hot one in the next run
  int stuck_pixels = 0;                    ///< they fire at every read-out
  double stuck_on_share = 0;
  int dead_pixels = 4;  ///< pixels that never fire; at most half of all

  double skin = 0.62;  ///< reflectances
  double black = 0.08;
  double white = 0.92;
  double dark = 0.001;          ///< dark current of the pixels, as a reflectance: keeps ln I finite without light
  double blur_px = 1.5;         ///< an edge fades over twice this: smoothstep, about a Gaussian of 0.7 px
  bool hiding = false;          ///< a nearer marker hides a farther one; otherwise overlapping markers add up
  double shadow = 0;            ///< a pushed tip darkens the skin below its marker by this share
  double shadow_mm_per_mm = 0;  ///< over this length per depth
  double flicker_depth = 0;     ///< the light is 1 + depth sin(2 pi hz t), t from the first read-out
  double flicker_hz = 100;

  // These differ from run to run and are not fields.
  double veil = 0.02;  ///< stray light, as a reflectance, >= 0
  LightDrift light_drift;
  double noise_factor = 1.0;  ///< factor on background, leak and shot noise, due to temperature, >= 0
  std::size_t run_index = 0;  ///< among the camera's runs: determines the hot pixels
};

/// How far the edge between black and white moves until a pixel on it crosses the threshold: the threshold over the mean gradient
/// of ln I across the edge. With the defaults 0.25 / (2.23 / 3 px) = 0.34 px.
inline double crossing_px(const EventCameraOptions& o) {
  const double contrast = std::log((o.dark + o.veil + o.white) / (o.dark + o.veil + o.black));
  return o.threshold * 2 * o.blur_px / std::abs(contrast);
}

template <class Fields>
void list_fields(Fields& fields, EventCameraOptions& o) {
  fields("preset", o.preset);
  fields("size", o.size, 1, 4096);
  fields("px_per_mm", o.px_per_mm, 0, 1000);
  fields("shift_x_mm", o.shift_x_mm, -20, 20);
  fields("shift_y_mm", o.shift_y_mm, -20, 20);
  fields("rotation_rad", o.rotation_rad, -0.2, 0.2);
  fields("readout_us", o.readout_us, 1, 1e6);
  fields("scan_us_per_column", o.scan_us_per_column, -1000, 1000);
  fields("scan_us_per_row", o.scan_us_per_row, -1000, 1000);
  fields("wander_us", o.wander_us, 0, 1000);
  fields("wander_s", o.wander_s, 1e-3, 1e3);
  fields("jitter_us", o.jitter_us, 0, 1000);
  fields("readout_events_per_s", o.readout_events_per_s, 0, 1e12);
  fields("readout_limit", o.readout_limit, 0, 4096 * 4096);
  fields("threshold", o.threshold, 1e-6, 1e3);
  fields("threshold_sigma", o.threshold_sigma, 0, 1e3);
  fields("threshold_floor", o.threshold_floor, 1e-6, 1e3);
  fields("residual", o.residual, 0, 1);
  fields("refractory_us", o.refractory, 0, 10'000'000);
  fields("bandwidth_hz", o.bandwidth_hz, 0, 1e6);
  fields("bandwidth_floor", o.bandwidth_floor, 0, 1);
  fields("background_hz", o.background_hz, 0, 10'000);
  fields("background_spread_decades", o.background_spread_decades, 0, 2);
  fields("background_regularity", o.background_regularity, 0.1, 100);
  fields("background_on_share", o.background_on_share, 0, 1);
  fields("background_on_spread", o.background_on_spread, 0, 0.45);
  fields("leak_hz", o.leak_hz, 0, 10'000);
  fields("leak_spread_decades", o.leak_spread_decades, 0, 2);
  fields("shot_hz", o.shot_hz, 0, 10'000);
  fields("hot_pixels", o.hot_pixels, 0, 100'000);
  fields("hot_hz", o.hot_hz, 1e-3, 1e6);
  fields("hot_on_shares", o.hot_on_shares, 0, 1);
  fields("hot_regularity", o.hot_regularity, 0, 1);
  fields("hot_turnover", o.hot_turnover, 0, 1);
  fields("stuck_pixels", o.stuck_pixels, 0, 100'000);
  fields("stuck_on_share", o.stuck_on_share, 0, 1);
  fields("dead_pixels", o.dead_pixels, 0, 8'388'608);
  fields("skin", o.skin, 0, 10);
  fields("black", o.black, 0, 10);
  fields("white", o.white, 0, 10);
  fields("dark", o.dark, 1e-6, 1);
  fields("blur_px", o.blur_px, 0.01, 100);
  fields("hiding", o.hiding);
  fields("shadow", o.shadow, 0, 1);
  fields("shadow_mm_per_mm", o.shadow_mm_per_mm, 0, 5);
  fields("flicker_depth", o.flicker_depth, 0, 0.99);
  fields("flicker_hz", o.flicker_hz, 0, 100'000);
}

/// @throws Error  with the first option that is out of its range
void check(const EventCameraOptions& options);

/// The skin in the middle of this camera's image.
SkinView view_of(const EventCameraOptions& options);

/// For run.json: "variable" if a read-out lasts longer when it has many events, else "constant".
inline std::string_view readout_mode_of(const EventCameraOptions& options) {
  return options.readout_events_per_s > 0 ? "variable" : "constant";
}

constexpr std::size_t pixel_count(events::SensorSize size) {
  return static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
}

}  // namespace tactile::simulation
