#include "tactile/characterise/second_reading.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace tactile::characterise {
namespace {

constexpr std::size_t parts_per_recording = 20;
constexpr std::size_t groups = 8;  // of pixels
constexpr std::int64_t tick_us = 2'000;
constexpr std::size_t ahead = 16;  // events whose pixels are prefetched
constexpr std::uint32_t usual = std::numeric_limits<std::uint32_t>::max();

/// Sums over the intervals of one unusual pixel.
struct Intervals {
  double n = 0, sum = 0, squares = 0;
};

/// Events of one part of a recording.
struct Part {
  double on = 0, off = 0, unusual = 0, hot = 0, seconds = 0;
};

/// Counts the events of each ordinary pixel in pairs of successive windows.
class WindowCounter {
 public:
  WindowCounter(const std::vector<bool>& ordinary, double window_us)
      : ordinary_(ordinary),
        window_us_(window_us),
        counts_{std::vector<std::uint16_t>(ordinary.size()), std::vector<std::uint16_t>(ordinary.size())} {}

  void begin_recording() {
    for (auto& counts : counts_) std::fill(counts.begin(), counts.end(), std::uint16_t{0});
    window_ = 0;
  }
  void add(std::size_t pixel, std::int64_t t_us) {
    const auto window = static_cast<std::int64_t>(static_cast<double>(t_us) * per_us_);
    if (window / 2 > window_ / 2) end_pair(window);
    window_ = std::max(window_, window);
    std::uint16_t& count = counts_[static_cast<std::size_t>(window_ % 2)][pixel];
    if (count < std::numeric_limits<std::uint16_t>::max()) ++count;
  }
  /// A pair that the recording covers counts too. @param length_us  of the recording
  void end_recording(double length_us) {
    if (length_us >= window_us_ * static_cast<double>(window_ - window_ % 2 + 2) * (1 - 1e-6)) end_pair(window_ + 2);
  }
  void prefetch(std::size_t pixel) const { __builtin_prefetch(&counts_[static_cast<std::size_t>(window_ % 2)][pixel], 1); }
  const std::array<WindowSums, groups>& sums() const { return sums_; }

 private:
  void end_pair(std::int64_t next) {
    const std::int64_t empty_pairs = next / 2 - window_ / 2 - 1;
    for (std::size_t pixel = 0; pixel < ordinary_.size(); ++pixel) {
      if (!ordinary_[pixel]) continue;
      WindowSums& sums = sums_[pixel % groups];
      sums.add(counts_[0][pixel], counts_[1][pixel]);
      sums.pairs += static_cast<double>(empty_pairs);
    }
    for (auto& counts : counts_) std::fill(counts.begin(), counts.end(), std::uint16_t{0});
    window_ = next;
  }

  const std::vector<bool>& ordinary_;
  double window_us_, per_us_ = 1 / window_us_;
  std::array<std::vector<std::uint16_t>, 2> counts_;
  std::array<WindowSums, groups> sums_{};
  std::int64_t window_ = 0;
};

/// The tick that holds `t`, of ticks at whole multiples of their length.
std::int64_t tick_of(CameraTime t) {
  const std::int64_t us = us_of(t);
  return us / tick_us - (us % tick_us < 0 ? 1 : 0);
}

/// Windows with two events of a mean pixel, if two of them fit into the shortest recording.
double window_us(const FirstReading& first, const std::vector<bool>& ordinary) {
  constexpr double events_in_window = 2;
  double events = 0, pixels = 0, shortest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < ordinary.size(); ++i) {
    if (!ordinary[i]) continue;
    events += first.counts.events(i);
    pixels += 1;
  }
  for (const ReadRecording& recording : first.recordings) shortest = std::min(shortest, recording.seconds());
  const double hz = events / std::max(1.0, pixels) / first.counts.seconds;
  return 1e6 * std::min(shortest / 2, events_in_window / std::max(hz, 1e-9));
}

}  // namespace

struct SecondReading::State {
  State(const FirstReading& reading, const UnusualPixels& unusual_ones, bool has_touched)
      : first(reading),
        ordinary(ordinary_pixels(reading.counts, unusual_ones)),
        unusual_index(ordinary.size(), usual),
        unusual(unusual_ones),
        intervals(unusual_ones.pixels.size()),
        fired_when_touched(ordinary.size()),
        windows(ordinary, window_us(reading, ordinary)),
        neighbours(reading.counts.size, ordinary),
        interval(ordinary.size()),
        largest(ordinary.size()),
        quiet(has_touched ? reading.counts.size : events::SensorSize{}),
        touched(quiet),
        is_touched(has_touched) {
    const auto width = static_cast<std::size_t>(reading.counts.size.width);
    for (std::size_t i = 0; i < unusual.pixels.size(); ++i)
      unusual_index[static_cast<std::size_t>(unusual.pixels[i].y) * width + static_cast<std::size_t>(unusual.pixels[i].x)] =
          static_cast<std::uint32_t>(i);
  }
  void add(const events::Event& event, std::int64_t t_us, std::int64_t tick);
  void begin_part(double seconds);
  void prefetch(const events::Event& event) const;
  Measured regularity_of_unusual() const;
  void put_background(Sensor& sensor) const;
  void put_dead(Sensor& sensor, const NoiseModel& model) const;

  const FirstReading& first;
  std::vector<bool> ordinary;
  std::vector<std::uint32_t> unusual_index;
  UnusualPixels unusual;
  std::vector<Intervals> intervals;
  std::vector<bool> fired_when_touched;
  std::vector<Part> parts;
  WindowCounter windows;
  NeighbourMeter neighbours;
  IntervalMeter interval;
  LargestCountMeter largest;
  PassageMeter quiet, touched;
  bool is_touched;
};

void SecondReading::State::prefetch(const events::Event& event) const {
  const std::size_t pixel =
      static_cast<std::size_t>(event.y) * static_cast<std::size_t>(first.counts.size.width) + static_cast<std::size_t>(event.x);
  __builtin_prefetch(&unusual_index[pixel]);
  interval.prefetch(pixel);
  largest.prefetch(pixel);
  windows.prefetch(pixel);
  neighbours.prefetch(pixel);
}

void SecondReading::State::begin_part(double seconds) {
  parts.push_back({.seconds = seconds});
  neighbours.begin_part();
  largest.begin_part();
  quiet.begin_part();
}

void SecondReading::State::add(const events::Event& event, std::int64_t t_us, std::int64_t tick) {
  const std::size_t pixel =
      static_cast<std::size_t>(event.y) * static_cast<std::size_t>(first.counts.size.width) + static_cast<std::size_t>(event.x);
  const std::uint32_t index = unusual_index[pixel];
  const std::optional<std::int64_t> since = interval.add(pixel, t_us);
  largest.add(pixel, tick, index == usual);
  Part& part = parts.back();
  if (index != usual) {
    part.unusual += 1;
    part.hot += unusual.pixels[index].is_hot();
    if (!since) return;
    Intervals& sums = intervals[index];
    const auto length = static_cast<double>(*since);
    sums.n += 1;
    sums.sum += length;
    sums.squares += length * length;
    return;
  }
  (event.on ? part.on : part.off) += 1;
  windows.add(pixel, t_us);
  neighbours.add(pixel, tick);
  if (is_touched) quiet.add(pixel, event.on != 0, t_us);
}

SecondReading::SecondReading(const FirstReading& first, const UnusualPixels& unusual, bool is_touched)
    : state_(std::make_unique<State>(first, unusual, is_touched)) {}
SecondReading::~SecondReading() = default;

void SecondReading::read_quiet(OpenRecording& open, const ReadRecording& recording, const ProgressCallback& progress) {
  State& s = *state_;
  const double length_us = static_cast<double>(between(recording.first, recording.last).count());
  const double part_us = length_us / parts_per_recording;
  const std::int64_t first_tick = tick_of(recording.first);
  s.windows.begin_recording();
  s.interval.begin_recording();
  s.largest.begin_recording();
  std::size_t part = 0;
  s.begin_part(part_us * 1e-6);
  open.for_packets(
      recording.stretch(),
      [&](std::span<const events::Event> events) {
        for (std::size_t i = 0; i < events.size(); ++i) {
          if (i + ahead < events.size()) s.prefetch(events[i + ahead]);
          const events::Event& event = events[i];
          const std::int64_t t_us = between(recording.first, event.t).count();
          while (part + 1 < parts_per_recording && static_cast<double>(t_us) >= part_us * static_cast<double>(part + 1)) {
            ++part;
            s.begin_part(part_us * 1e-6);
          }
          s.add(event, t_us, tick_of(event.t) - first_tick);
        }
      },
      progress);
  while (++part < parts_per_recording) s.begin_part(part_us * 1e-6);
  s.windows.end_recording(length_us);
  s.neighbours.end_recording(static_cast<std::int64_t>(length_us) / tick_us + 1);
  s.quiet.end_recording(recording.seconds());
}

void SecondReading::read_touched(OpenRecording& open, const ProgressCallback& progress) {
  State& s = *state_;
  const auto width = static_cast<std::size_t>(s.first.counts.size.width);
  constexpr std::int64_t part_us = 250'000;
  std::optional<CameraTime> first;
  std::int64_t last_us = 0, part = -1;
  open.for_packets(
      [&](std::span<const events::Event> events) {
        for (const events::Event& event : events) {
          if (!first) first = event.t;
          const std::int64_t t_us = std::max<std::int64_t>(0, between(*first, event.t).count());
          last_us = std::max(last_us, t_us);
          if (last_us / part_us > part) {
            part = last_us / part_us;
            s.touched.begin_part();
          }
          const std::size_t pixel = static_cast<std::size_t>(event.y) * width + static_cast<std::size_t>(event.x);
          s.fired_when_touched[pixel] = true;
          if (s.ordinary[pixel]) s.touched.add(pixel, event.on != 0, t_us);
        }
      },
      progress);
  s.touched.end_recording(static_cast<double>(last_us) * 1e-6);
}

Measured SecondReading::State::regularity_of_unusual() const {
  constexpr double fewest = 10;
  std::vector<double> regularities;
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    const Intervals& sums = intervals[i];
    const UnusualPixel::Kind kind = unusual.pixels[i].kind;
    if (sums.n < fewest || kind == UnusualPixel::Kind::stuck || kind == UnusualPixel::Kind::lit) continue;
    const double mean = sums.sum / sums.n, variance = std::max(0.0, sums.squares / sums.n - mean * mean) * sums.n / (sums.n - 1);
    regularities.push_back(1 - std::sqrt(variance) / std::max(mean, 1e-9));
  }
  return regularities.empty() ? Measured{} : mean_of(regularities);
}

void SecondReading::State::put_background(Sensor& sensor) const {
  const auto pixels = static_cast<double>(std::count(ordinary.begin(), ordinary.end(), true));
  std::vector<CountPart> on, off, all, without_hot;
  for (const Part& part : parts) {
    on.push_back({part.on, part.seconds * pixels});
    off.push_back({part.off, part.seconds * pixels});
    all.push_back({part.on + part.off + part.unusual, part.seconds});
    without_hot.push_back({part.on + part.off + part.unusual - part.hot, part.seconds});
  }
  sensor.background.on_hz = ratio_of(on);
  sensor.background.off_hz = ratio_of(off);
  sensor.rate_hz = ratio_of(all);
  sensor.rate_without_hot_hz = ratio_of(without_hot);
  WindowSums sums;
  for (const WindowSums& group : windows.sums()) sums += group;
  const NoiseModel model = noise_model(sums);
  std::vector<double> shapes, spreads;  // without one group of pixels each
  for (std::size_t left_out = 0; left_out < groups; ++left_out) {
    WindowSums others;
    for (std::size_t i = 0; i < groups; ++i) {
      if (i != left_out) others += windows.sums()[i];
    }
    const NoiseModel other = noise_model(others);
    shapes.push_back(other.shape);
    spreads.push_back(other.spread);
  }
  constexpr double jackknife = groups - 1;  // times the uncertainty of the mean
  sensor.background.regularity = {model.shape, jackknife * mean_of(shapes).uncertainty};
  sensor.background.spread_decades = {model.spread / std::numbers::ln10,
                                      jackknife * mean_of(spreads).uncertainty / std::numbers::ln10};
  // A sensor of the same kind has other pixels.
  for (Measured* rate : {&sensor.background.on_hz, &sensor.background.off_hz}) {
    const double between_pixels = rate->value * std::sqrt(std::expm1(model.spread * model.spread) / std::max(1.0, pixels));
    rate->uncertainty = std::hypot(rate->uncertainty, between_pixels);
  }
  double warm = 0, hot = 0;
  for (const UnusualPixel& pixel : unusual.pixels) (pixel.is_hot() ? hot : warm) += pixel.rate_hz.value * pixel.rate_hz.value;
  const double ordinary_pixels = pixels * std::hypot(sensor.background.on_hz.uncertainty, sensor.background.off_hz.uncertainty);
  sensor.rate_without_hot_hz.uncertainty = std::hypot(sensor.rate_without_hot_hz.uncertainty, ordinary_pixels, std::sqrt(warm));
  sensor.rate_hz.uncertainty = std::hypot(sensor.rate_hz.uncertainty, ordinary_pixels, std::sqrt(warm + hot));
  put_dead(sensor, model);
}

void SecondReading::State::put_dead(Sensor& sensor, const NoiseModel& model) const {
  constexpr std::size_t most_listed = 1000;
  const auto width = static_cast<std::size_t>(first.counts.size.width);
  double silent = 0, events = 0, pixels = 0, untouched = 0;
  for (std::size_t i = 0; i < ordinary.size(); ++i) {
    if (!ordinary[i]) continue;
    pixels += 1;
    events += first.counts.events(i);
    untouched += !fired_when_touched[i];
    silent += first.counts.events(i) == 0 && !fired_when_touched[i];
  }
  DeadPixels& dead = sensor.dead;
  dead.silent = static_cast<std::uint64_t>(silent);
  std::vector<double> means;  // of the recordings
  for (const ReadRecording& recording : first.recordings)
    means.push_back(events / std::max(1.0, pixels) * recording.seconds() / first.counts.seconds);
  dead.expected = untouched * silent_share(model, means);
  constexpr double model_error = 0.1;  // the rates are not quite log-normal
  dead.count.value = std::max(0.0, silent - dead.expected);
  dead.count.uncertainty = std::hypot(std::sqrt(silent), model_error * dead.expected);
  if (sensor.background.is_disturbed()) dead.count.uncertainty = std::max(dead.count.uncertainty, dead.count.value);
  if (!dead.is_known() || 2 * dead.expected >= silent) return;
  for (std::size_t i = 0; i < ordinary.size() && dead.places.size() < most_listed; ++i) {
    if (ordinary[i] && first.counts.events(i) == 0 && !fired_when_touched[i])
      dead.places.emplace_back(static_cast<int>(i % width), static_cast<int>(i / width));
  }
}

void SecondReading::put_into(Sensor& sensor) const {
  const State& s = *state_;
  s.put_background(sensor);
  sensor.background.on_spread = on_spread(s.first.counts, s.ordinary);
  sensor.background_rates_hz = rate_quantiles(s.first.counts, s.ordinary);
  sensor.unusual.regularity = s.regularity_of_unusual();
  sensor.neighbours = s.neighbours.neighbours();
  sensor.shortest_interval_us = s.interval.shortest_us();
  sensor.refractory_us = sensor.shortest_interval_us;
  const double period_us = s.first.counts.period_us;
  if (sensor.shortest_interval_us && period_us > 0) {
    const double readouts = std::max(1.0, std::nearbyint(sensor.shortest_interval_us->value / period_us));
    sensor.refractory_us = Measured{(readouts - 0.5) * period_us, period_us / std::sqrt(12.0)};
  }
  sensor.largest = s.largest.all();
  sensor.largest_ordinary = s.largest.ordinary();
  if (s.is_touched) sensor.passages = passages(s.touched, s.quiet);
}

}  // namespace tactile::characterise
