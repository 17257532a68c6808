#include "tactile/conversion/recording_output.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "tactile/conversion/event_npz.hpp"
#include "tactile/conversion/hdf5_recording.hpp"
#include "tactile/core/error.hpp"
#include "tactile/events/event_csv.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile::conversion {
namespace fs = std::filesystem;
namespace {

class Aedat4Output : public RecordingOutput {
 public:
  Aedat4Output(const fs::path& file, const std::vector<events::Stream>& streams, events::Compression compression,
               unsigned threads)
      : writer_(file, streams, {.compression = compression, .threads = threads}) {}
  void write(std::int32_t id, std::span<const events::Event> events) override { writer_.write_events(id, events); }
  void write(std::int32_t id, std::span<const events::ImuSample> samples) override { writer_.write_imu(id, samples); }
  void write(std::int32_t id, std::span<const events::Trigger> triggers) override { writer_.write_triggers(id, triggers); }
  void write(std::int32_t id, const events::Frame& frame) override { writer_.write_frame(id, frame); }
  void close() override { writer_.close(); }

 private:
  events::RecordingWriter writer_;
};

class Hdf5Output : public RecordingOutput {
 public:
  Hdf5Output(const fs::path& file, std::span<const events::Stream> streams) : writer_(file, streams) {}
  using RecordingOutput::write;
  void write(std::int32_t id, std::span<const events::Event> events) override { writer_.write_events(id, events); }
  void write(std::int32_t id, std::span<const events::ImuSample> samples) override { writer_.write_imu(id, samples); }
  void write(std::int32_t id, std::span<const events::Trigger> triggers) override { writer_.write_triggers(id, triggers); }
  void close() override { writer_.close(); }

 private:
  Hdf5RecordingWriter writer_;
};

/// CSV or NPZ: the events of one stream.
template <class Writer>
class EventOutput : public RecordingOutput {
 public:
  template <class... Arguments>
  explicit EventOutput(Arguments&&... arguments) : writer_(std::forward<Arguments>(arguments)...) {}
  using RecordingOutput::write;
  void write(std::int32_t, std::span<const events::Event> events) override { writer_.write(events); }
  std::uint64_t steps_back() const override { return writer_.steps_back(); }
  void close() override { writer_.close(); }

 private:
  Writer writer_;
};

}  // namespace

std::unique_ptr<RecordingOutput> open_output(const fs::path& file, const fs::path& in, const ConvertSummary& summary,
                                             unsigned threads) {
  std::vector<events::Stream> streams;
  const auto check_size = [&](const events::Stream& stream) {
    if (stream.type == events::StreamType::events && !stream.size) {
      throw Error(fmt::format("{}: its events have no sensor size (stream {}); expected a stream that declares one, or --crop",
                              in.string(), stream.id));
    }
  };
  for (const ConvertedStream& kept : summary.streams) streams.push_back(kept.stream);
  switch (summary.to) {
    case RecordingFormat::csv:
      return std::make_unique<EventOutput<events::EventCsvWriter>>(file);
    case RecordingFormat::npz:
      check_size(streams.front());
      return std::make_unique<EventOutput<EventNpzWriter>>(file, *summary.size);
    case RecordingFormat::hdf5:
      return std::make_unique<Hdf5Output>(file, streams);
    case RecordingFormat::raw:  // is never an output
    case RecordingFormat::aedat4:
      std::for_each(streams.begin(), streams.end(), check_size);
      break;
  }
  return std::make_unique<Aedat4Output>(file, streams, *summary.compression, threads);
}

}  // namespace tactile::conversion
