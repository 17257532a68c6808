#include "tactile/simulation/event_camera.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <string>

#include "tactile/core/error.hpp"
#include "tactile/simulation/fast_log.hpp"

namespace tactile::simulation {
namespace {

constexpr double shot_share_at_white = 0.25;    // of the shot noise in the dark (v2e)
constexpr std::int32_t long_ago = -20'000'000;  // in read-outs, longer than any reset

const EventCameraOptions& checked(const EventCameraOptions& options) {
  check(options);
  return options;
}

}  // namespace

EventCamera::EventCamera(const CameraPixels& pixels, const EventCameraOptions& options, CameraTime start, std::uint64_t seed,
                         std::span<const MarkerPose> rest)
    : pixels_(pixels),
      options_(checked(options)),
      px_per_mm_(view_of(options).px_per_mm),
      readout_s_(1e-6 * options.readout_us),
      start_(start),
      clock_(options, seed_for(seed, {"read-outs"})),
      random_(seed),
      background_(pixels, options, seed_for(seed, {"background"})),
      poses_(rest.begin(), rest.end()),
      markers_(rest.size()),
      before_(rest.size()),
      trails_(rest.size()),
      first_by_(rest.size()) {
  const std::size_t count = pixel_count(options.size);
  if (pixels.thresholds.size() != count)
    throw Error("simulated camera: the pixels are those of another size; expected as many as the image has");
  if (rest.size() > max_markers)
    throw Error(fmt::format("simulated camera: {} markers; expected {} at most", rest.size(), max_markers));
  const double blind = std::ceil(static_cast<double>(options.refractory.count()) / options.readout_us);
  blind_readouts_ = static_cast<std::int32_t>(std::max(1.0, blind));
  base_ = static_cast<float>(options.dark + options.veil);
  skin_level_ = log_of(intensity_of(static_cast<float>(options.skin)));

  remembered_.assign(count, skin_level_);
  last_fired_.assign(count, long_ago);
  for (std::size_t m = 0; m < poses_.size(); ++m) place(poses_[m], markers_[m]);
  for (const Marker& marker : markers_) {
    for (int y = marker.box.top; y < marker.box.bottom; ++y) {
      for (int x = marker.box.left; x < marker.box.right; ++x) remembered_[index_of(x, y)] = level_at(x, y);
    }
  }
  begin_to_follow();
  if (options.residual > 0) {
    for (std::size_t i = 0; i < count; ++i) {
      const auto off = static_cast<float>(options.residual * random_.uniform(-1.0, 1.0));
      if (!std::isinf(pixels.thresholds[i])) remembered_[i] += off * pixels.thresholds[i];
    }
  }
  draw_hot();
}

void EventCamera::draw_hot() {
  for (const SimulatedHotPixel& pixel : hot_pixels_of_run(pixels_, options_.run_index)) {
    const double between = std::max(0.01, 1.0 / (pixel.hz * readout_s_));  // at most one event per read-out
    if (pixel.stuck)
      stuck_.push_back({pixel.index, pixel.on_share, 0, 1});
    else
      hot_.push_back({pixel.index, pixel.on_share, between * random_.uniform(), between});
  }
}

void EventCamera::fire(int x, int y, float level, bool on, std::uint8_t cause) {
  const std::size_t index = index_of(x, y);
  if (readout_ - last_fired_[index] < blind_readouts_) return;
  last_fired_[index] = readout_;
  remembered_[index] = level;
  fired_.push_back({static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y), static_cast<std::uint8_t>(on), cause});
  if (blind_readouts_ > 1) in_reset_.push_back(static_cast<std::uint32_t>(index));
}

void EventCamera::fire_without_cause(std::uint32_t index, bool on) {
  if (readout_ - last_fired_[index] < blind_readouts_) return;
  const int x = static_cast<int>(index) % options_.size.width, y = static_cast<int>(index) / options_.size.width;
  fire(x, y, level_at(x, y), on, 0);
}

void EventCamera::add_noise() {
  // With more draws, every pixel has an event.
  const std::uint64_t enough = 16 * pixels_.thresholds.size();
  const auto draws = [&](double hz, const PixelLottery& lottery) {
    const double mean = hz * options_.noise_factor * readout_s_ * lottery.weight_sum();
    return mean > 0 ? std::min(enough, random_.poisson(mean)) : 0;
  };
  for (std::uint64_t left = draws(options_.leak_hz, pixels_.leak); left > 0; --left)
    fire_without_cause(pixels_.leak.draw(random_), true);
  for (std::uint64_t left = draws(options_.shot_hz, pixels_.shot); left > 0; --left) {
    const std::uint32_t index = pixels_.shot.draw(random_);
    const double chance = random_.uniform();
    const auto i = static_cast<int>(index);
    const float brightness =
        intensity_of(reflectance_at(i % options_.size.width, i / options_.size.width)) - static_cast<float>(options_.dark);
    const double kept = 1.0 - (1.0 - shot_share_at_white) * std::min(1.0, static_cast<double>(brightness));
    if (chance < kept) fire_without_cause(index, chance < 0.5 * kept);
  }
  background_.advance(static_cast<std::uint32_t>(readout_), [&](std::uint32_t index, bool on) { fire_without_cause(index, on); });
  const double fixed = options_.hot_regularity;  // a hot pixel may recharge before it fires again
  for (Hot& hot : hot_) {
    if (hot.next_readout > readout_) continue;
    fire_without_cause(hot.index, random_.uniform() < hot.on_share);
    // Several times in a read-out give one event.
    while (hot.next_readout <= readout_)
      hot.next_readout += hot.readouts_between * (fixed + (1.0 - fixed) * random_.exponential());
  }
  for (const Hot& stuck : stuck_) fire_without_cause(stuck.index, random_.uniform() < stuck.on_share);
}

void EventCamera::hold_in_reset() {
  std::erase_if(in_reset_, [&](std::uint32_t index) {
    remembered_[index] = level_at(static_cast<int>(index) % options_.size.width, static_cast<int>(index) / options_.size.width);
    return readout_ + 1 - last_fired_[index] >= blind_readouts_;
  });
}

/// Sorts by the stamps, then x, then y, with two stable counting sorts, because there are few different values.
void EventCamera::sort_fired() {
  constexpr std::size_t few = 64;
  const bool rows = clock_.scans_rows(), falls = clock_.falls();
  const auto [width, height] = options_.size;
  const unsigned last = static_cast<unsigned>(rows ? height : width) - 1U;
  const auto scanned = [&](const Fired& fired) -> unsigned {
    const unsigned place = rows ? fired.y : fired.x;
    return falls ? last - place : place;
  };
  const auto other = [&](const Fired& fired) -> unsigned { return rows ? fired.x : fired.y; };
  if (fired_.size() < few) {
    const auto key = [&](const Fired& fired) { return scanned(fired) << 16U | other(fired); };
    std::sort(fired_.begin(), fired_.end(), [&](const Fired& a, const Fired& b) { return key(a) < key(b); });
    return;
  }
  sorted_.resize(fired_.size());
  const auto sort_by = [&](auto place_of, int places) {
    places_.assign(static_cast<std::size_t>(places) + 1, 0);
    for (const Fired& fired : fired_) ++places_[place_of(fired) + 1U];
    for (std::size_t i = 1; i < places_.size(); ++i) places_[i] += places_[i - 1];
    for (const Fired& fired : fired_) sorted_[places_[place_of(fired)]++] = fired;
    fired_.swap(sorted_);
  };
  sort_by(other, rows ? width : height);
  sort_by(scanned, rows ? height : width);
}

/// The events of this read-out, sorted, limited and stamped.
EventCamera::ReadOut EventCamera::collect_fired() {
  sort_fired();
  fired_.resize(std::min(fired_.size(), static_cast<std::size_t>(options_.readout_limit)));
  ReadOut seen;
  events_.resize(fired_.size());
  const double begin_us = clock_.next_us();
  const CameraTime begin = start_ + microseconds{static_cast<std::int64_t>(begin_us)};
  for (std::size_t i = 0; i < fired_.size(); ++i) {
    const Fired& fired = fired_[i];
    CameraTime t = begin;
    if (clock_.scans()) t = start_ + microseconds{static_cast<std::int64_t>(begin_us + clock_.offset_us(fired.x, fired.y))};
    events_[i] = {.t = t, .x = static_cast<std::int16_t>(fired.x), .y = static_cast<std::int16_t>(fired.y), .on = fired.on};
    if (fired.cause == 0) continue;
    ++seen.caused;
    const std::uint32_t bit = 1U << (fired.cause - 1U);
    if ((seen.caused_by & bit) == 0) first_by_[fired.cause - 1U] = t;
    seen.caused_by |= bit;
  }
  seen.events = events_;
  seen.first_by = first_by_;
  fired_.clear();
  return seen;
}

void EventCamera::change_light(double t_s) {
  double light = options_.light_drift.at(t_s);
  if (options_.flicker_depth > 0) {
    const double phase = 2.0 * std::numbers::pi * options_.flicker_hz * t_s;
    light *= 1.0 + options_.flicker_depth * std::sin(phase);
  }
  light_ = static_cast<float>(light);
  base_ = static_cast<float>(options_.dark + light * options_.veil);
  skin_level_ = log_of(intensity_of(static_cast<float>(options_.skin)));
}

EventCamera::ReadOut EventCamera::read_out(std::span<const MarkerPose> poses) {
  assert(poses.size() == poses_.size() && "a read-out shows the markers that were there at the start");
  const bool flickers = options_.flicker_depth > 0, drifts = options_.light_drift.amplitude > 0;
  if (flickers || drifts) change_light(1e-6 * clock_.next_us());
  std::uint32_t moved = 0, sideways = 0;
  for (std::size_t m = 0; m < poses.size(); ++m) {
    if (follows_ ? !moves_visibly(m, poses[m]) : poses[m] == poses_[m]) continue;
    moved |= 1U << m;
    if (poses[m].x != poses_[m].x || poses[m].scale != poses_[m].scale) sideways |= 1U << m;
    poses_[m] = poses[m];
    std::swap(before_[m], markers_[m]);
    place(poses[m], markers_[m]);
  }
  for (std::size_t m = 0; m < poses.size(); ++m) {
    if (follows_)
      follow(m, moved);
    else if ((moved >> m & 1U) != 0)
      look_at_moved(m, moved, (sideways >> m & 1U) != 0);
  }
  if (flickers)
    look_at_rows(0, 1);
  else if (drifts)
    look_at_rows(readout_ % drift_rows, drift_rows);
  add_noise();
  if (!in_reset_.empty()) hold_in_reset();
  const ReadOut seen = collect_fired();
  clock_.advance(seen.events.size());
  ++readout_;
  return seen;
}

}  // namespace tactile::simulation
