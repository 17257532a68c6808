#include "tactile/characterise/scene.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "tactile/characterise/flicker.hpp"
#include "tactile/characterise/readout_bins.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/robust_statistics.hpp"
#include "tactile/events/hot_pixels.hpp"

namespace tactile::characterise {
namespace {

constexpr std::size_t fewest_for_readout = 2000;
constexpr std::size_t most_for_readout = 16'384;  // of a second's events; to search for a period in all costs 50 ms and more

double background_of(std::span<const events::Event> events, double seconds) {
  constexpr double bin_s = 0.02, quiet_share = 0.1, deviations = 1.2816;  // of normal noise, a tenth lies below the mean by more
  const auto bins = static_cast<std::size_t>(std::max(1.0, std::floor(seconds / bin_s + 1e-9)));
  std::vector<double> counts(bins);
  for (const events::Event& event : events) {
    const auto us = static_cast<double>(between(events.front().t, event.t).count());
    if (const auto bin = static_cast<std::size_t>(us * 1e-6 / bin_s); bin < bins) counts[bin] += 1;
  }
  const double quiet = quantile(counts, quiet_share);
  return (quiet + deviations * std::sqrt(quiet)) / std::min(bin_s, seconds);
}

double hot_pixels_of(std::span<const events::Event> events, double seconds, events::SensorSize size) {
  std::vector<std::uint32_t> counts(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height));
  for (const events::Event& event : events) {
    ++counts[static_cast<std::size_t>(event.y) * static_cast<std::size_t>(size.width) + static_cast<std::size_t>(event.x)];
  }
  return static_cast<double>(events::find_hot_pixels(counts, size, seconds).pixels.size());
}

/// Flicker of the pieces of an eighth of the window whose rate is that of the background, about: a touch shakes the skin.
void add_flicker(Scene& scene, std::span<const events::Event> events, double seconds, const events::Readout& readout) {
  constexpr int pieces = 8;
  constexpr double most_of_background = 1.25;
  const ReadoutBins bins(readout);
  const microseconds piece{std::llround(seconds * 1e6 / pieces)};
  FlickerMeter meter(bins.length_us, readout.kind == events::Readout::Kind::none ? 0 : readout.period_us.value, pieces * piece);
  const double most = most_of_background * scene.background_hz * seconds / pieces;
  const CameraTime first = events.front().t;
  auto begin = events.begin();
  for (int i = 1; i <= pieces; ++i) {
    const auto end = std::find_if(begin, events.end(), [&](const auto& event) { return between(first, event.t) >= i * piece; });
    const auto in_piece = std::span(begin, end);
    begin = end;
    if (in_piece.empty() || static_cast<double>(in_piece.size()) > most) continue;
    meter.begin_recording();
    const std::int64_t first_bin = bins.index_of(between(first, in_piece.front().t).count(), in_piece.front());
    for (const events::Event& event : in_piece) meter.add(bins.index_of(between(first, event.t).count(), event) - first_bin);
  }
  for (const FlickerLine& line : meter.flicker().lines) {
    if (line.depth.value <= scene.flicker_depth) continue;
    scene.flicker_depth = line.depth.value;
    scene.flicker_hz = line.hz.value;
  }
}

void widen(SceneRanges::Range& range, double value, bool is_first) {
  range.low = is_first ? value : std::min(range.low, value);
  range.high = is_first ? value : std::max(range.high, value);
}

/// In kev/s, with the digits that count.
std::string kev(double hz) { return hz >= 9'950 ? fmt::format("{:.0f}", hz / 1000) : fmt::format("{:.2g}", hz / 1000); }

void add_background(std::vector<std::string>& parts, const Scene& scene, const SceneRanges& training) {
  constexpr double margin = 1.5;
  const SceneRanges::Range& known = training.background_hz;
  if (scene.background_hz <= margin * known.high && scene.background_hz >= known.low / margin) return;
  parts.push_back(
      fmt::format("background {} kev/s, training {} to {}", kev(scene.background_hz), kev(known.low), kev(known.high)));
}

void add_hot_pixels(std::vector<std::string>& parts, const Scene& scene, const SceneRanges& training) {
  const SceneRanges::Range& known = training.hot_pixels;
  if (scene.hot_pixels <= 2 * known.high + 10) return;
  parts.push_back(fmt::format("{:.0f} hot pixels, training {:.0f} to {:.0f}", scene.hot_pixels, known.low, known.high));
}

void add_flicker(std::vector<std::string>& parts, const Scene& scene, const SceneRanges& training) {
  const SceneRanges::Range& known = training.flicker_depth;
  if (scene.flicker_depth <= 1.5 * known.high + 0.1) return;
  parts.push_back(fmt::format("flicker of {:.0f} Hz with a depth of {:.2f}, training at most {:.2f}", scene.flicker_hz,
                              scene.flicker_depth, known.high));
}

void add_readout(std::vector<std::string>& parts, const Scene& scene, const SceneRanges& training) {
  constexpr double margin = 1.1;
  if (!scene.readout_us || !training.readout_us) return;
  const SceneRanges::Range& known = *training.readout_us;
  if (*scene.readout_us <= margin * known.high && *scene.readout_us >= known.low / margin) return;
  const std::string now =
      *scene.readout_us > 0 ? fmt::format("read-outs every {:.1f} us", *scene.readout_us) : std::string("no read-outs");
  parts.push_back(known.high > 0 ? fmt::format("{}, training every {:.1f} to {:.1f} us", now, known.low, known.high)
                                 : now + ", training without");
}

}  // namespace

nlohmann::json json_of(const Scene& scene) {
  return {{"background_hz", scene.background_hz},
          {"hot_pixels", scene.hot_pixels},
          {"flicker_hz", scene.flicker_hz},
          {"flicker_depth", scene.flicker_depth},
          {"readout_us", scene.readout_us ? nlohmann::json(*scene.readout_us) : nlohmann::json()}};
}

Scene scene_of(std::span<const events::Event> events, double seconds, events::SensorSize size, const events::MaskPixels& mask) {
  const events::PixelMask masked(size, mask);
  std::vector<events::Event> kept;
  events = masked.without(events, kept);
  Scene scene;
  if (events.empty() || !(seconds > 0)) return scene;
  scene.background_hz = background_of(events, seconds);
  scene.hot_pixels = hot_pixels_of(events, seconds, size);
  events::ReadoutMeter meter(size, events::ReadoutMeter::Extent::beginning);
  meter.add(events.first(std::min(events.size(), most_for_readout)));
  const events::Readout readout = meter.readout();
  using Kind = events::Readout::Kind;
  // The shortest distance of unsteady read-outs depends on the rate, and noise of an asynchronous sensor may look like it.
  if (events.size() >= fewest_for_readout && readout.kind != Kind::unsteady)
    scene.readout_us = readout.kind == Kind::none ? 0 : readout.period_us.value;
  add_flicker(scene, events, seconds, readout);
  return scene;
}

SceneWindow::SceneWindow() {
  // Written once, so that the system gives the memory now.
  events_.assign(most_events, events::Event{});
  events_.clear();
}

std::size_t SceneWindow::add(std::span<const events::Event> events) {
  if (is_full_ || events.empty()) return 0;
  const CameraTime begin = events_.empty() ? events.front().t : events_.front().t;
  const auto begins_later = [begin](const events::Event& event) { return between(begin, event.t) >= length; };
  const bool all = !begins_later(events.back());
  const auto in_time =
      all ? events.size() : static_cast<std::size_t>(std::find_if(events.begin(), events.end(), begins_later) - events.begin());
  const std::size_t taken = std::min(in_time, most_events - events_.size());
  events_.insert(events_.end(), events.begin(), events.begin() + static_cast<std::ptrdiff_t>(taken));
  is_full_ = !all || events_.size() == most_events;
  return taken;
}

bool SceneWindow::is_half_full() const { return is_full_ || seconds() >= 0.5 * std::chrono::duration<double>(length).count(); }

double SceneWindow::seconds() const {
  if (events_.empty()) return 0;
  const bool is_cut = !is_full_ || events_.size() == most_events;
  return std::chrono::duration<double>(is_cut ? between(events_.front().t, events_.back().t) : length).count();
}

void SceneWindow::clear() {
  events_.clear();
  is_full_ = false;
}

std::vector<Scene> scenes_of(events::RecordingReader& recording, const events::MaskPixels& mask) {
  const events::Stream& stream = events::event_stream(recording);
  if (!stream.size) throw Error(recording.file().string() + ": its event stream declares no size; expected sizeX and sizeY");
  std::vector<Scene> scenes;
  SceneWindow window;
  const auto take = [&] {
    scenes.push_back(scene_of(window.events(), window.seconds(), *stream.size, mask));
    window.clear();
  };
  events::for_all_events(recording, stream.id, [&](std::span<const events::Event> events) {
    while (!events.empty()) {
      events = events.subspan(window.add(events));
      if (window.is_full()) take();
    }
  });
  if (window.is_half_full()) take();
  return scenes;
}

void SceneRanges::add_run(std::span<const Scene> windows) {
  if (windows.empty()) return;
  const bool is_first = runs++ == 0;
  std::vector<double> backgrounds, hot;
  for (const Scene& scene : windows) {
    backgrounds.push_back(scene.background_hz);
    hot.push_back(scene.hot_pixels);
    widen(flicker_depth, scene.flicker_depth, is_first && backgrounds.size() == 1);
    if (!scene.readout_us) continue;
    const bool is_known = readout_us.has_value();
    if (!is_known) readout_us.emplace(Range{});
    widen(*readout_us, *scene.readout_us, !is_known);
  }
  widen(background_hz, lower_median(backgrounds), is_first);
  widen(hot_pixels, lower_median(hot), is_first);
}

void to_json(nlohmann::json& json, const SceneRanges& ranges) {
  const auto pair = [](const SceneRanges::Range& range) { return std::array{range.low, range.high}; };
  json = {{"runs", ranges.runs},
          {"background_hz", pair(ranges.background_hz)},
          {"hot_pixels", pair(ranges.hot_pixels)},
          {"flicker_depth", pair(ranges.flicker_depth)},
          {"readout_us", ranges.readout_us ? nlohmann::json(pair(*ranges.readout_us)) : nlohmann::json()}};
}

void from_json(const nlohmann::json& json, SceneRanges& ranges) {
  const std::string where = "scene";
  const auto range = [&where](const nlohmann::json& from, const char* name) {
    const auto pair = member<std::vector<double>>(from, name, where);
    const bool is_range = pair.size() == 2 && std::isfinite(pair[1]) && pair[0] >= 0 && pair[0] <= pair[1];
    if (!is_range)
      throw Error(fmt::format("{}: {} is no range; expected two numbers of 0 or more in ascending order", where, name));
    return SceneRanges::Range{pair[0], pair[1]};
  };
  ranges.runs = member<std::uint64_t>(json, "runs", where);
  ranges.background_hz = range(json, "background_hz");
  ranges.hot_pixels = range(json, "hot_pixels");
  ranges.flicker_depth = range(json, "flicker_depth");
  if (!member<nlohmann::json>(json, "readout_us", where).is_null()) ranges.readout_us = range(json, "readout_us");
}

std::string departures(const Scene& scene, const SceneRanges& training) {
  std::vector<std::string> parts;
  add_background(parts, scene, training);
  add_hot_pixels(parts, scene, training);
  add_flicker(parts, scene, training);
  add_readout(parts, scene, training);
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : "; ") + part;
  return text;
}

std::string departures(std::span<const Scene> windows, const SceneRanges& training) {
  if (windows.size() == 1) return departures(windows.front(), training);
  SceneState state(training);
  for (const Scene& scene : windows) {
    if (const auto change = state.next(scene); change && change->leaves) return change->text;
  }
  return {};
}

std::optional<SceneChange> SceneState::next(const Scene& scene) {
  const std::string text = departures(scene, training_);
  disagreeing_ = text.empty() == outside_ ? disagreeing_ + 1 : 0;
  if (disagreeing_ < to_change) return std::nullopt;
  disagreeing_ = 0;
  outside_ = !outside_;
  return SceneChange{
      outside_, outside_ ? text
                         : fmt::format("as in training again, background {} kev/s, training {} to {}", kev(scene.background_hz),
                                       kev(training_.background_hz.low), kev(training_.background_hz.high))};
}

}  // namespace tactile::characterise
