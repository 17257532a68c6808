#include "tactile/characterise/first_reading.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "tactile/characterise/neighbour_steps.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/robust_statistics.hpp"

namespace tactile::characterise {
namespace {

constexpr std::int64_t most_pixels = std::int64_t{1} << 22;

/// Takes the times of packets.
class PacketMeter {
 public:
  void begin_recording() { last_.reset(); }
  void add(std::span<const events::Event> packet) {
    if (packet.empty()) return;
    CameraTime first = packet.front().t, last = first;
    for (const events::Event& event : packet) {
      first = std::min(first, event.t);
      last = std::max(last, event.t);
    }
    ++times_.packets;
    double waits = 0;
    for (const events::Event& event : packet) waits += us_between(event.t, last);
    waits_.push_back({waits, static_cast<double>(packet.size())});
    if (waits_.size() > most_kept) halve();
    times_.longest_us = std::max(times_.longest_us, us_between(first, last));
    if (last_) {
      if (first < *last_) ++times_.back;
      if (intervals_.size() < most_kept) intervals_.push_back(us_between(*last_, last));
    }
    last_ = std::max(last_.value_or(last), last);
  }
  PacketTimes times() const {
    PacketTimes times = times_;
    times.wait_us = ratio_of(waits_);
    if (!intervals_.empty())
      times.interval_us = {median(intervals_), (quantile(intervals_, 0.84) - quantile(intervals_, 0.16)) / 2};
    return times;
  }

 private:
  static constexpr std::size_t most_kept = 1 << 16;
  static double us_between(CameraTime a, CameraTime b) { return static_cast<double>(between(a, b).count()); }
  void halve() {
    for (std::size_t i = 0; i + 1 < waits_.size(); i += 2)
      waits_[i / 2] = {waits_[i].count + waits_[i + 1].count, waits_[i].measure + waits_[i + 1].measure};
    waits_.resize(waits_.size() / 2);
  }

  PacketTimes times_;
  std::vector<CountPart> waits_;
  std::vector<double> intervals_;
  std::optional<CameraTime> last_;
};

void read_recording(OpenRecording& open, ReadRecording& recording, FirstReading& reading, PacketMeter& packets,
                    const ProgressCallback& progress) {
  events::ReadoutMeter readout(open.stream().size, events::ReadoutMeter::Extent::all);
  const auto width = static_cast<std::size_t>(reading.counts.size.width);
  const QuietStretch stretch = recording.stretch();
  bool any = false;
  packets.begin_recording();
  open.for_packets(
      stretch,
      [&](std::span<const events::Event> events) {
        readout.add(events);
        packets.add(events);
        for (const events::Event& event : events) {
          recording.first = any ? std::min(recording.first, event.t) : event.t;
          recording.last = any ? std::max(recording.last, event.t) : event.t;
          any = true;
          const std::size_t pixel = static_cast<std::size_t>(event.y) * width + static_cast<std::size_t>(event.x);
          std::uint32_t& count = (event.on ? reading.counts.on : reading.counts.off)[pixel];
          if (count < std::numeric_limits<std::uint32_t>::max()) ++count;
        }
      },
      progress);
  recording.readout = readout.readout();
}

bool moves_in(OpenRecording& open, const QuietStretch& stretch, const ProgressCallback& progress) {
  NeighbourSteps steps(*open.stream().size, stretch.begin);
  open.for_packets(
      stretch, [&](std::span<const events::Event> events) { steps.add(events); }, progress);
  return steps.is_motion();
}

/// Of several recordings of one sensor.
events::Readout combined_readout(const std::vector<ReadRecording>& recordings) {
  events::Readout readout = recordings.front().readout;
  std::vector<Measured> periods, steps, jitters;
  for (const ReadRecording& recording : recordings) {
    const events::Readout& other = recording.readout;
    if (&recording != &recordings.front()) readout.events += other.events;
    if (other.kind != readout.kind || other.scan != readout.scan) continue;
    periods.push_back(other.period_us);
    steps.push_back(other.step_us);
    jitters.push_back(other.jitter_us);
  }
  if (readout.kind == events::Readout::Kind::none) return readout;
  readout.period_us = combined(periods);
  if (readout.scan != events::Scan::none) readout.step_us = combined(steps);
  readout.jitter_us = combined(jitters);
  return readout;
}

}  // namespace

OpenRecording::OpenRecording(const std::filesystem::path& file, const CharacteriseOptions& options,
                             std::optional<events::SensorSize> expected)
    : reader_(file, options.threads), stream_(events::event_stream(reader_, options.stream)) {
  const std::string where = file.string();
  if (!stream_.size || stream_.size->width < 1 || stream_.size->height < 1)
    throw Error(where + ": its event stream declares no size; expected sizeX and sizeY");
  const auto [width, height] = *stream_.size;
  if (std::int64_t{width} * height > most_pixels)
    throw Error(
        fmt::format("{}: declares a sensor of {}x{} pixels; expected at most {} pixels", where, width, height, most_pixels));
  if (expected && *expected != *stream_.size) {
    throw Error(fmt::format("{}: its sensor has {}x{} pixels; expected {}x{}, as the first recording has", where, width, height,
                            expected->width, expected->height));
  }
}

microseconds FirstReading::shortest() const {
  microseconds shortest = microseconds::max();
  for (const ReadRecording& recording : recordings) shortest = std::min(shortest, between(recording.first, recording.last));
  return shortest;
}

void OpenRecording::for_packets(const std::function<void(std::span<const events::Event>)>& use,
                                const ProgressCallback& progress) {
  for_packets({CameraTime::min(), CameraTime::max()}, use, progress);
}

void OpenRecording::for_packets(const QuietStretch& stretch, const std::function<void(std::span<const events::Event>)>& use,
                                const ProgressCallback& progress) {
  const auto is_inside = [&](const events::Event& event) { return stretch.begin <= event.t && event.t < stretch.end; };
  std::vector<events::Event> inside;
  for (const events::PacketRecord& packet : reader_.packets()) {
    report_progress(progress, packet.payload_offset, reader_.file_size(), reader_.file().filename().string());
    if (packet.stream_id != stream_.id || packet.last < stretch.begin || packet.first >= stretch.end) continue;
    const std::span<const events::Event> events = reader_.read_events(packet);
    if (std::all_of(events.begin(), events.end(), is_inside)) {
      use(events);
      continue;
    }
    inside.clear();
    std::copy_if(events.begin(), events.end(), std::back_inserter(inside), is_inside);
    if (!inside.empty()) use(inside);
  }
}

FirstReading read_first(const std::vector<std::filesystem::path>& quiet, const CharacteriseOptions& options,
                        const ProgressCallback& progress) {
  FirstReading reading;
  PacketMeter packets;
  std::optional<events::SensorSize> size;
  bool has_packets = true;
  double longest_s = 0;
  for (const std::filesystem::path& file : quiet) {
    OpenRecording open(file, options, size);
    if (!size) {
      size = reading.counts.size = *open.stream().size;
      reading.camera = open.stream().source;
      reading.counts.on.resize(static_cast<std::size_t>(size->width) * static_cast<std::size_t>(size->height));
      reading.counts.off.resize(reading.counts.on.size());
    }
    has_packets &= open.reader().index() != events::PacketIndex::pieces;
    QuietMeter meter(*size);
    open.for_packets([&](std::span<const events::Event> events) { meter.add(events); }, progress);
    if (meter.seconds() == 0) {
      throw Error(fmt::format("{}: {}; expected a recording of some seconds", file.string(),
                              meter.is_empty() ? "holds no event" : "all events have the same time"));
    }
    reading.seconds_left_out += meter.seconds();
    longest_s = std::max(longest_s, meter.seconds());
    if (moves_in(open, meter.quietest(), progress)) continue;
    for (const QuietStretch& stretch : meter.stretches()) {
      ReadRecording& recording = reading.recordings.emplace_back();
      recording.file = file;
      recording.stream = open.stream().id;
      recording.first = stretch.begin;
      recording.last = after(stretch.end, microseconds{-1});
      read_recording(open, recording, reading, packets, progress);
      reading.counts.seconds += recording.seconds();
      reading.seconds_left_out -= recording.seconds();
    }
  }
  if (reading.recordings.empty()) {
    const double least_s = std::chrono::duration<double>(QuietMeter::shortest).count();
    throw Error(fmt::format("{}: {}; expected {} s or more without touch and motion", quiet.front().string(),
                            longest_s < least_s ? fmt::format("lasts {:.3g} s", longest_s) : "something moves all the time",
                            least_s));
  }
  reading.readout = combined_readout(reading.recordings);
  if (reading.readout.kind == events::Readout::Kind::steady) reading.counts.period_us = reading.readout.period_us.value;
  if (has_packets) reading.packets = packets.times();
  return reading;
}

}  // namespace tactile::characterise
