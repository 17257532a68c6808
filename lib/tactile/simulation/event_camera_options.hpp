#pragma once

#include <cstddef>

#include "tactile/core/time.hpp"
#include "tactile/events/event.hpp"
#include "tactile/simulation/skin.hpp"

namespace tactile::simulation {

/// The camera's pixels and the light. Thresholds are in ln of the intensity. Intensities are reflectances under constant light,
/// so 1 is white paper.
///
/// Sources: v2e and ESIM for thresholds, dark current, leak and shot noise; Faris et al., arXiv:2403.10120, for the read-out and
/// for hot pixels that fire more than useful ones. The numbers of hot and dead pixels, how often
/// they change, and their share of ON events are assumptions.
struct EventCameraOptions {
  events::SensorSize size{640, 480};
  double px_per_mm = 0;  ///< 0: the whole skin fits into the image; see view_of
  microseconds readout{200};

  double threshold = 0.25;        ///< mean over the pixels
  double threshold_sigma = 0.03;  ///< between pixels
  double threshold_floor = 0.01;  ///< no pixel is more sensitive than this
  double residual = 1.0;          ///< largest error of a pixel's memory at the start, as a share of its threshold
  /// Time in reset after an event. It is at most a read-out, because hot pixels of this kind of sensor reach one event per
  /// read-out: the read-out itself is the dead time. v2e's 500 us belongs to another sensor.
  microseconds refractory{200};

  double leak_hz = 0.02;             ///< ON events without cause, mean per pixel
  double leak_spread_decades = 0.1;  ///< of that rate between pixels, standard deviation of its log10
  double shot_hz = 0.06;             ///< ON and OFF equally, in the dark; 1/4 of it at white
  int hot_pixels = 24;               ///< pixels that fire by themselves
  double hot_min_hz = 100.0;         ///< their rates are log-uniform between these
  double hot_max_hz = 2500.0;
  double hot_on_share = 0.7;
  double hot_turnover = 0.05;  ///< chance that another pixel replaces a hot one in the next run
  int dead_pixels = 4;         ///< pixels that never fire; at most half of all
  int readout_limit = 28'000;  ///< events of one read-out that reach the host: 140 Mev/s at 5000 read-outs/s, as measured

  double skin = 0.62;  ///< reflectances
  double black = 0.08;
  double white = 0.92;
  double dark = 0.001;       ///< dark current of the pixels, as a reflectance: keeps ln I finite without light
  double blur_px = 1.5;      ///< an edge fades over twice this: smoothstep, about a Gaussian of 0.7 px
  double flicker_depth = 0;  ///< the light is 1 + depth sin(2 pi hz t), t from the first read-out
  double flicker_hz = 100;

  // These differ from run to run and are not fields.
  double veil = 0.02;         ///< stray light, as a reflectance, >= 0
  double noise_factor = 1.0;  ///< factor on leak and shot noise, due to temperature, >= 0
  std::size_t run_index = 0;  ///< among the camera's runs: determines the hot pixels
};

template <class Fields>
void list_fields(Fields& fields, EventCameraOptions& o) {
  fields("size", o.size, 1, 4096);
  fields("px_per_mm", o.px_per_mm, 0, 1000);
  fields("readout_us", o.readout, 1, 1'000'000);
  fields("threshold", o.threshold, 1e-6, 1e3);
  fields("threshold_sigma", o.threshold_sigma, 0, 1e3);
  fields("threshold_floor", o.threshold_floor, 1e-6, 1e3);
  fields("residual", o.residual, 0, 1);
  fields("refractory_us", o.refractory, 0, 10'000'000);
  fields("leak_hz", o.leak_hz, 0, 10'000);
  fields("leak_spread_decades", o.leak_spread_decades, 0, 2);
  fields("shot_hz", o.shot_hz, 0, 10'000);
  fields("hot_pixels", o.hot_pixels, 0, 100'000);
  fields("hot_min_hz", o.hot_min_hz, 1e-3, 1e6);
  fields("hot_max_hz", o.hot_max_hz, 1e-3, 1e6);
  fields("hot_on_share", o.hot_on_share, 0, 1);
  fields("hot_turnover", o.hot_turnover, 0, 1);
  fields("dead_pixels", o.dead_pixels, 0, 4096 * 4096 / 2);
  fields("readout_limit", o.readout_limit, 0, 4096 * 4096);
  fields("skin", o.skin, 0, 10);
  fields("black", o.black, 0, 10);
  fields("white", o.white, 0, 10);
  fields("dark", o.dark, 1e-6, 1);
  fields("blur_px", o.blur_px, 0.01, 100);
  fields("flicker_depth", o.flicker_depth, 0, 0.99);
  fields("flicker_hz", o.flicker_hz, 0, 100'000);
}

/// @throws Error  with the first option that is out of its range
void check(const EventCameraOptions& options);

/// The skin in the middle of this camera's image.
SkinView view_of(const EventCameraOptions& options);

constexpr std::size_t pixel_count(events::SensorSize size) {
  return static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
}

}  // namespace tactile::simulation
