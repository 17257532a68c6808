#include "tactile/review/run_events.hpp"

#include <algorithm>

#include "tactile/core/error.hpp"
#include "tactile/events/simulated_recording.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/labels/recording_span.hpp"
#include "tactile/pictures/drawing.hpp"
#include "tactile/pictures/moments.hpp"
#include "tactile/review/count_bytes.hpp"
#include "tactile/video/picture_codec.hpp"

namespace tactile::review {
namespace {

/// As all commands render, with this history.
heatmaps::HeatmapOptions rendering_of(microseconds history) {
  heatmaps::HeatmapOptions options;
  options.history = history;
  if (history % options.tick != 0us) options.tick = history;  // no tick is rendered but this one
  return options;
}

/// The window's pictures. The last window's moment is handed to `use`.
void for_moment(events::RecordingReader& recording, const RunFacts& facts, CameraTime end, microseconds history,
                const std::function<void(const pictures::Moment&)>& use) {
  const std::vector<CameraTime> times{end};
  pictures::for_moments(recording, facts.stream_id, rendering_of(history), times, pictures::MomentDetail::heatmap, use);
}

}  // namespace

RunFacts read_facts(const RunFolder& run) { return RunEvents(run).facts(); }

RunEvents::RunEvents(const RunFolder& run) : run_(run), recording_(run.events()) {
  const events::Stream& stream = events::event_stream(recording_);
  facts_.stream_id = stream.id;
  if (stream.size) facts_.sensor = *stream.size;
  const labels::RecordingSpan span = labels::span_of_events(run);
  facts_.first = span.first;
  facts_.last = span.last;
  for (const events::PacketRecord& packet : recording_.packets()) {
    if (packet.stream_id == stream.id) facts_.events += static_cast<std::uint64_t>(std::max<std::int64_t>(0, packet.elements));
  }
  const auto streams = recording_.streams();
  facts_.has_imu =
      std::any_of(streams.begin(), streams.end(), [](const events::Stream& s) { return s.type == events::StreamType::imu; });
  facts_.simulated = events::is_simulated(run);
}

events::SensorSize RunEvents::sensor() const {
  if (facts_.sensor.width <= 0 || facts_.sensor.height <= 0)
    throw Error(run_.name() + ": the stream of events declares no size; expected its sensor's");
  return facts_.sensor;
}

void RunEvents::for_all(const std::function<void(std::span<const events::Event>)>& use, const Advance& advance) const {
  events::RecordingReader recording(run_.events());  // its own, so that windows are answered in the meantime
  const auto packets = recording.packets();
  for (std::size_t i = 0; i < packets.size(); ++i) {
    if (packets[i].stream_id != facts_.stream_id) continue;
    use(recording.read_events(packets[i]));
    advance(static_cast<double>(i + 1) / static_cast<double>(packets.size()));
  }
}

std::vector<events::ImuSample> RunEvents::imu() const {
  const std::scoped_lock lock(guard_);
  std::vector<events::ImuSample> all;
  for (const events::PacketRecord& packet : recording_.packets()) {
    if (recording_.stream(packet.stream_id).type != events::StreamType::imu) continue;
    const std::vector<events::ImuSample> samples = recording_.read_imu(packet);
    all.insert(all.end(), samples.begin(), samples.end());
  }
  std::stable_sort(all.begin(), all.end(), [](const events::ImuSample& a, const events::ImuSample& b) { return a.t < b.t; });
  return all;
}

std::optional<std::vector<events::Event>> RunEvents::events_in(CameraTime begin, CameraTime end, std::size_t most) const {
  struct TooMany {};
  const std::scoped_lock lock(guard_);
  std::vector<events::Event> all;
  try {
    events::for_events_between(recording_, facts_.stream_id, begin, end, [&](std::span<const events::Event> events) {
      if (all.size() + events.size() > most) throw TooMany{};
      all.insert(all.end(), events.begin(), events.end());
    });
  } catch (const TooMany&) {
    return std::nullopt;
  }
  return all;
}

std::string RunEvents::counts_before(CameraTime end, microseconds history) const {
  CountBytes counts(sensor());
  const std::scoped_lock lock(guard_);
  events::for_events_between(recording_, facts_.stream_id, before(end, history), end,
                             [&](std::span<const events::Event> events) { counts.add(events); });
  return counts.bytes();
}

std::string RunEvents::heatmap_before(CameraTime end, microseconds history) const {
  sensor();
  const std::scoped_lock lock(guard_);
  std::string bytes;
  for_moment(recording_, facts_, end, history, [&](const pictures::Moment& moment) {
    bytes =
        heatmap_bytes({moment.heatmap.cols, moment.heatmap.rows}, moment.events, {moment.heatmap.data, moment.heatmap.total()});
  });
  return bytes;
}

std::string RunEvents::picture_before(CameraTime end, microseconds history, int width) const {
  sensor();
  const std::scoped_lock lock(guard_);
  std::vector<unsigned char> png;
  for_moment(recording_, facts_, end, history, [&](const pictures::Moment& moment) {
    pictures::BrightnessMeter meter;
    meter.add(moment);
    const int wide = std::min(width, moment.counts.cols);
    const int high = std::max(1, moment.counts.rows * wide / moment.counts.cols);
    const cv::Mat small = pictures::fitted_picture(moment.counts, {wide, high});
    png = video::png_of(pictures::false_colours(small, meter.result().counts, pictures::ColourScale::root),
                        "the picture of events");
  });
  return {png.begin(), png.end()};
}

}  // namespace tactile::review
