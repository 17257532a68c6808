#include "tactile/conversion/convert.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <memory>
#include <span>
#include <utility>

#include "tactile/conversion/event_npz.hpp"
#include "tactile/conversion/hdf5_recording.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/event_csv.hpp"
#include "tactile/events/output_file.hpp"
#include "tactile/events/packet_contents.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile {
namespace fs = std::filesystem;
namespace {

constexpr std::array common_sizes{SensorSize{320, 240}, SensorSize{346, 260}, SensorSize{640, 480}};

/// What the options leave of an element's time.
class Cut {
 public:
  explicit Cut(const ConvertOptions& options)
      : from_(options.from.value_or(CameraTime::min())),
        to_(options.to),
        from_waits_(options.from && options.from_counts_from_first),
        to_waits_(options.to && options.to_counts_from_first),
        asked_(options.from || options.to) {
    if (from_waits_ == to_waits_) check();
  }

  /// What counts from the first element does so from here on; does nothing once it does.
  void begin_at(CameraTime first) {
    if (!from_waits_ && !to_waits_) return;
    if (from_waits_) from_ = after(first, microseconds{us_of(from_)});
    if (to_waits_) to_ = after(first, microseconds{us_of(*to_)});
    from_waits_ = to_waits_ = false;
    check();
  }

  bool holds(CameraTime t) const { return t >= from_ && (!to_ || t < *to_); }
  bool asked() const { return asked_; }
  std::string text() const {
    return fmt::format("[{}, {})", from_ == CameraTime::min() ? "begin" : std::to_string(us_of(from_)),
                       to_ ? std::to_string(us_of(*to_)) : "end");
  }

  /// The elements inside the cut, in place where all are; the view is of `elements` or `kept`.
  template <class Element>
  std::span<const Element> of(std::span<const Element> elements, std::vector<Element>& kept) const {
    const auto is_inside = [this](const Element& element) { return holds(element.t); };
    if (!asked_ || std::all_of(elements.begin(), elements.end(), is_inside)) return elements;
    kept.clear();
    std::copy_if(elements.begin(), elements.end(), std::back_inserter(kept), is_inside);
    return kept;
  }

 private:
  void check() const {
    if (to_ && *to_ <= from_)
      throw Error(fmt::format("the cut from {} to {} us is empty; expected an end behind the begin", us_of(from_), us_of(*to_)));
  }

  CameraTime from_;
  std::optional<CameraTime> to_;
  bool from_waits_, to_waits_;  ///< for the first element
  bool asked_;
};

/// Times met so far.
class TimeRange {
 public:
  template <class Element>
  void add(std::span<const Element> elements) {
    for (const Element& element : elements) add(element.t);
  }
  void add(CameraTime t) {
    first = first ? std::min(*first, t) : t;
    last = last ? std::max(*last, t) : t;
  }

  std::optional<CameraTime> first, last;
};

std::string text_of(const TimeRange& range) {
  return range.first ? fmt::format("its elements lie from {} to {}", us_of(*range.first), us_of(*range.last))
                     : std::string("it holds no element at all");
}

bool holds_one_stream(RecordingFormat format) { return format == RecordingFormat::csv || format == RecordingFormat::npz; }

bool can_hold(RecordingFormat format, StreamType type) {
  if (holds_one_stream(format)) return type == StreamType::events;
  if (format == RecordingFormat::hdf5) return type != StreamType::other && type != StreamType::frames;
  return type != StreamType::other;
}

void check_options(const ConvertOptions& options, RecordingFormat from, RecordingFormat to) {
  if (from == RecordingFormat::npz) throw Error("NPZ is written, not read; expected an input that ends in .aedat4, .csv or .h5");
  if (from == RecordingFormat::csv && to == RecordingFormat::csv)
    throw Error("from CSV to CSV there is nothing to convert; expected one .aedat4 file");
  if (from == RecordingFormat::csv && !options.streams.empty())
    throw Error("--stream chooses among the streams of an AEDAT4 or HDF5 input; expected it left out for CSV");
  if (from == RecordingFormat::aedat4 && (options.size || options.source))
    throw Error("--size and --source describe a CSV or HDF5 input; expected them left out for AEDAT4");
  if (to != RecordingFormat::aedat4 && options.compression)
    throw Error(fmt::format("--compression is for an AEDAT4 output; expected it left out for {}", name_of(to)));
  if (holds_one_stream(to) && options.streams.size() > 1)
    throw Error(fmt::format("{} streams for one {}; expected one --stream, for streams are never merged", options.streams.size(),
                            name_of(to)));
  if (options.crop && (options.crop->width < 1 || options.crop->height < 1 || options.crop->x < 0 || options.crop->y < 0))
    throw Error("the crop is empty or begins outside the sensor; expected X,Y,WxH with X and Y from 0, W and H from 1");
}

SensorSize size_that_holds(SensorSize extent) {
  const auto fits = [&](const SensorSize& size) { return extent.width <= size.width && extent.height <= size.height; };
  const auto* found = std::find_if(common_sizes.begin(), common_sizes.end(), fits);
  return found == common_sizes.end() ? extent : *found;
}

/// Which streams of the input the output gets, at the size that the crop leaves of them.
void choose_streams(std::span<const Stream> streams, const fs::path& in, const ConvertOptions& options, ConvertSummary& summary) {
  std::vector<const Stream*> chosen;
  for (const std::string& choice : options.streams) chosen.push_back(&event_stream(streams, in.string(), choice));
  if (chosen.empty() && holds_one_stream(summary.to)) chosen.push_back(&event_stream(streams, in.string()));
  const auto among_chosen = [&](const auto& is_it) {
    return chosen.empty() || std::any_of(chosen.begin(), chosen.end(), [&](const Stream* c) { return is_it(*c); });
  };
  for (const Stream& stream : streams) {
    const bool is_wanted =
        stream.type == StreamType::events
            ? among_chosen([&](const Stream& c) { return c.id == stream.id; })
            : stream.source.empty() || among_chosen([&](const Stream& c) { return c.source == stream.source; });
    if (!is_wanted || !can_hold(summary.to, stream.type)) {
      summary.left_out.push_back(stream);
      continue;
    }
    Stream kept = completed(stream);
    if (options.crop && (stream.type == StreamType::events || stream.type == StreamType::frames)) {
      const PixelRegion& crop = *options.crop;
      if (stream.size && (crop.width > stream.size->width - crop.x || crop.height > stream.size->height - crop.y)) {
        throw Error(fmt::format("{}: the crop {},{},{}x{} reaches beyond the {}x{} pixels of stream {}; expected one within",
                                in.string(), crop.x, crop.y, crop.width, crop.height, stream.size->width, stream.size->height,
                                stream.id));
      }
      kept.size = SensorSize{crop.width, crop.height};
    }
    if (stream.type == StreamType::events && !summary.size) summary.size = kept.size;
    summary.streams.push_back({std::move(kept), 0});
  }
  if (summary.streams.empty())
    throw Error(in.string() + ": no stream that the output could hold; expected events, frames, imu or triggers");
}

/// Where the elements go: a file of one of the formats.
class Output {
 public:
  virtual ~Output() = default;
  virtual void write(std::int32_t stream_id, std::span<const Event> events) = 0;
  virtual void write(std::int32_t, std::span<const ImuSample>) {}  // what it cannot hold does not come
  virtual void write(std::int32_t, std::span<const Trigger>) {}
  virtual void write(std::int32_t, const Frame&) {}
  virtual std::uint64_t steps_back() const { return 0; }
  virtual void close() = 0;
};

class Aedat4Output : public Output {
 public:
  Aedat4Output(const fs::path& file, std::vector<Stream> streams, Compression compression)
      : writer_(file, std::move(streams), {.compression = compression}) {}
  void write(std::int32_t id, std::span<const Event> events) override { writer_.write_events(id, events); }
  void write(std::int32_t id, std::span<const ImuSample> samples) override { writer_.write_imu(id, samples); }
  void write(std::int32_t id, std::span<const Trigger> triggers) override { writer_.write_triggers(id, triggers); }
  void write(std::int32_t id, const Frame& frame) override { writer_.write_frame(id, frame); }
  void close() override { writer_.close(); }

 private:
  RecordingWriter writer_;
};

class Hdf5Output : public Output {
 public:
  Hdf5Output(const fs::path& file, std::span<const Stream> streams) : writer_(file, streams) {}
  using Output::write;
  void write(std::int32_t id, std::span<const Event> events) override { writer_.write_events(id, events); }
  void write(std::int32_t id, std::span<const ImuSample> samples) override { writer_.write_imu(id, samples); }
  void write(std::int32_t id, std::span<const Trigger> triggers) override { writer_.write_triggers(id, triggers); }
  void close() override { writer_.close(); }

 private:
  Hdf5RecordingWriter writer_;
};

/// CSV or NPZ: the events of one stream.
template <class Writer>
class EventOutput : public Output {
 public:
  template <class... Arguments>
  explicit EventOutput(Arguments&&... arguments) : writer_(std::forward<Arguments>(arguments)...) {}
  using Output::write;
  void write(std::int32_t, std::span<const Event> events) override { writer_.write(events); }
  std::uint64_t steps_back() const override { return writer_.steps_back(); }
  void close() override { writer_.close(); }

 private:
  Writer writer_;
};

std::unique_ptr<Output> open_output(const fs::path& file, const fs::path& in, const ConvertSummary& summary) {
  std::vector<Stream> streams;
  const auto check_size = [&](const Stream& stream) {
    if (stream.type == StreamType::events && !stream.size) {
      throw Error(fmt::format("{}: its events have no sensor size (stream {}); expected a stream that declares one, or --crop",
                              in.string(), stream.id));
    }
  };
  for (const ConvertedStream& kept : summary.streams) streams.push_back(kept.stream);
  switch (summary.to) {
    case RecordingFormat::csv:
      return std::make_unique<EventOutput<EventCsvWriter>>(file);
    case RecordingFormat::npz:
      check_size(streams.front());
      return std::make_unique<EventOutput<EventNpzWriter>>(file, *summary.size);
    case RecordingFormat::hdf5:
      return std::make_unique<Hdf5Output>(file, streams);
    case RecordingFormat::aedat4:
      std::for_each(streams.begin(), streams.end(), check_size);
      break;
  }
  return std::make_unique<Aedat4Output>(file, std::move(streams), *summary.compression);
}

/// The way of every element from input to output: cut, cropped, counted.
class Passage {
 public:
  Passage(const fs::path& in, const fs::path& out, const ConvertOptions& options, ConvertSummary& summary)
      : in_(in),
        cut_(options),
        crop_(options.crop),
        summary_(summary),
        whole_(out, options.replace ? IfThere::replace : IfThere::refuse),
        output_(open_output(whole_.path(), in, summary)) {}

  /// Tells when the first element is; else what is passed first is it.
  void begin_at(CameraTime first) { cut_.begin_at(first); }

  /// Where the elements of this stream go; nothing if they are left out.
  ConvertedStream* place_of(std::int32_t stream_id) {
    const auto found = std::find_if(summary_.streams.begin(), summary_.streams.end(),
                                    [&](const ConvertedStream& s) { return s.stream.id == stream_id; });
    return found == summary_.streams.end() ? nullptr : &*found;
  }
  void pass(ConvertedStream& to, std::span<const Event> events) {
    note(events);
    std::span<const Event> inside = cut_.of(events, events_kept_);
    if (crop_) {
      events_cropped_.clear();
      crop_events(inside, *crop_, events_cropped_);
      summary_.cropped_events += inside.size() - events_cropped_.size();
      inside = events_cropped_;
    }
    hand_over(to, inside);
  }
  void pass(ConvertedStream& to, std::span<const ImuSample> samples) {
    note(samples);
    hand_over(to, cut_.of(samples, imu_kept_));
  }
  void pass(ConvertedStream& to, std::span<const Trigger> triggers) {
    note(triggers);
    hand_over(to, cut_.of(triggers, triggers_kept_));
  }
  void pass(ConvertedStream& to, const Frame& frame) {
    note(std::span(&frame, 1));
    if (!cut_.holds(frame.t)) return;
    const std::optional<Frame> part = crop_ ? cropped(frame, *crop_, bytes_per_pixel(frame.format)) : std::nullopt;
    if (crop_ && !part) {
      ++summary_.cropped_frames;
      return;
    }
    note_time(to, frame.t);
    ++to.elements;
    output_->write(to.stream.id, crop_ ? *part : frame);
  }

  void finish() {
    if (cut_.asked() && !written_.first && summary_.cropped_events == 0)
      throw Error(fmt::format("{}: the cut {} us leaves nothing; {}, and a '+' in front counts from the first of them",
                              in_.string(), cut_.text(), text_of(all_)));
    const bool any = std::any_of(summary_.streams.begin(), summary_.streams.end(), [](const ConvertedStream& s) {
      return s.elements > 0 && (s.stream.type == StreamType::events || s.stream.type == StreamType::frames);
    });
    if (summary_.cropped_events > 0 && !any) {
      throw Error(fmt::format("{}: the crop leaves none of {} events; expected a region where there are some", in_.string(),
                              summary_.cropped_events));
    }
    summary_.first_in = all_.first;
    summary_.first = written_.first;
    summary_.last = written_.last;
    summary_.steps_back = output_->steps_back();
    output_->close();
    output_.reset();
    whole_.commit();
  }

 private:
  template <class Element>
  void note(std::span<const Element> elements) {
    all_.add(elements);
    if (all_.first) cut_.begin_at(*all_.first);
  }

  template <class Element>
  void hand_over(ConvertedStream& to, std::span<const Element> inside) {
    if (inside.empty()) return;
    for (const Element& element : inside) note_time(to, element.t);
    to.elements += inside.size();
    output_->write(to.stream.id, inside);
  }

  /// Notes the time of an element that is about to be written.
  /// @throws Error  that names the input, if it steps back and the output is a recording, whose times never fall
  void note_time(const ConvertedStream& to, CameraTime t) {
    written_.add(t);
    if (holds_one_stream(summary_.to)) return;
    const auto [newest, is_first] = newest_.try_emplace(to.stream.id, t);
    if (!is_first && t < newest->second) {
      throw Error(
          fmt::format("{}: stream {} goes back in time, from {} to {} us; expected times that never fall: CSV and NPZ "
                      "keep events as they are, and a cut leaves the step out, with --from-us above {} or --to-us up to {}",
                      in_.string(), to.stream.id, us_of(newest->second), us_of(t), us_of(newest->second), us_of(t)));
    }
    newest->second = t;
  }

  fs::path in_;
  Cut cut_;
  std::optional<PixelRegion> crop_;
  ConvertSummary& summary_;
  WholeFile whole_;
  std::unique_ptr<Output> output_;
  TimeRange all_, written_;
  std::map<std::int32_t, CameraTime> newest_;  ///< written of each stream
  std::vector<Event> events_kept_, events_cropped_;
  std::vector<ImuSample> imu_kept_;
  std::vector<Trigger> triggers_kept_;
};

void convert_from_aedat4(const fs::path& in, const fs::path& out, const ConvertOptions& options, ConvertSummary& summary,
                         const ProgressCallback& progress) {
  RecordingReader recording(in, options.threads);
  choose_streams(recording.streams(), in, options, summary);
  if (summary.to == RecordingFormat::aedat4) summary.compression = options.compression.value_or(recording.compression());
  Passage passage(in, out, options, summary);
  std::optional<CameraTime> first;
  for (const PacketRecord& packet : recording.packets()) {
    if (packet.elements > 0 && passage.place_of(packet.stream_id) != nullptr)
      first = std::min(first.value_or(packet.first), packet.first);
  }
  if (first) passage.begin_at(*first);
  for (const PacketRecord& packet : recording.packets()) {
    tell(progress, packet.payload_offset, recording.file_size(), out.filename().string());
    ConvertedStream* const to = passage.place_of(packet.stream_id);
    if (to == nullptr) continue;  // every packet of a kept stream is read: the data table's times may be wrong
    switch (to->stream.type) {
      case StreamType::events:
        passage.pass(*to, std::span<const Event>(recording.read_events(packet)));
        break;
      case StreamType::imu:
        passage.pass(*to, std::span<const ImuSample>(recording.read_imu(packet)));
        break;
      case StreamType::triggers:
        passage.pass(*to, std::span<const Trigger>(recording.read_triggers(packet)));
        break;
      case StreamType::frames:
        if (const auto frame = recording.read_frame(packet)) passage.pass(*to, *frame);
        break;
      case StreamType::other:
        break;
    }
  }
  summary.problems = recording.problems();
  passage.finish();
}

void convert_from_hdf5(const fs::path& in, const fs::path& out, const ConvertOptions& options, ConvertSummary& summary,
                       const ProgressCallback& progress) {
  Hdf5RecordingReader recording(in, options.size, options.source);
  choose_streams(recording.streams(), in, options, summary);
  if (summary.to == RecordingFormat::aedat4) summary.compression = options.compression.value_or(Compression::lz4);
  Passage passage(in, out, options, summary);
  std::vector<std::int32_t> ids;
  for (const ConvertedStream& kept : summary.streams) ids.push_back(kept.stream.id);
  const auto pass = [&](const Stream& stream, const auto& elements) { passage.pass(*passage.place_of(stream.id), elements); };
  recording.read(ids, {.events = pass, .imu = pass, .triggers = pass}, progress);
  passage.finish();
}

/// The sensor that a CSV's events need, 0x0 without events; checks every line on the way.
SensorSize extent_of(const fs::path& in, const ProgressCallback& progress) {
  EventCsvReader csv(in);
  int last_x = -1, last_y = -1;
  for (auto events = csv.next(); !events.empty(); events = csv.next()) {
    for (const Event& event : events) {
      last_x = std::max<int>(last_x, event.x);
      last_y = std::max<int>(last_y, event.y);
    }
    tell(progress, csv.bytes_read(), 2 * csv.file_size(), in.filename().string());
  }
  return {last_x + 1, last_y + 1};
}

void convert_from_csv(const fs::path& in, const fs::path& out, const ConvertOptions& options, ConvertSummary& summary,
                      const ProgressCallback& progress) {
  std::optional<SensorSize> size = options.size;
  if (!size) {
    const SensorSize extent = extent_of(in, progress);
    if (extent.width == 0)
      throw Error(in.string() + ": no events to tell the sensor's size from; expected events, or --size WxH");
    size = size_that_holds(extent);
    summary.size_guessed = true;
  }
  const Stream stream = event_stream_declaration(*size, options.source.value_or("csv"));
  choose_streams({&stream, 1}, in, options, summary);
  if (summary.to == RecordingFormat::aedat4) summary.compression = options.compression.value_or(Compression::lz4);

  EventCsvReader csv(in, size);
  Passage passage(in, out, options, summary);
  const std::uint64_t passes = summary.size_guessed ? 2 : 1;
  for (auto events = csv.next(); !events.empty(); events = csv.next()) {
    passage.pass(summary.streams.front(), events);
    tell(progress, csv.bytes_read() + (passes - 1) * csv.file_size(), passes * csv.file_size(), out.filename().string());
  }
  passage.finish();
}

}  // namespace

std::string_view name_of(RecordingFormat format) {
  constexpr std::array<std::string_view, 4> names{"AEDAT4", "CSV", "HDF5", "NPZ"};
  return names.at(static_cast<std::size_t>(format));
}

RecordingFormat recording_format_of(const fs::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".aedat4") return RecordingFormat::aedat4;
  if (extension == ".csv") return RecordingFormat::csv;
  if (extension == ".h5" || extension == ".hdf5") return RecordingFormat::hdf5;
  if (extension == ".npz") return RecordingFormat::npz;
  throw Error(fmt::format("{}: {}; expected .aedat4, .csv, .h5 or .npz", file.string(),
                          extension.empty() ? "no extension that names a format" : "unknown extension '" + extension + "'"));
}

ConvertSummary convert_recording(const fs::path& in, const fs::path& out, const ConvertOptions& options,
                                 const ProgressCallback& progress) {
  ConvertSummary summary;
  summary.from = recording_format_of(in);
  summary.to = recording_format_of(out);
  check_options(options, summary.from, summary.to);
  if (!fs::exists(in)) throw Error(in.string() + ": no such file; expected a recording");
  if (!fs::is_regular_file(in)) throw Error(in.string() + ": is no regular file; expected a recording, which is read in places");
  check_target(out, in, options.replace);
  switch (summary.from) {
    case RecordingFormat::csv:
      convert_from_csv(in, out, options, summary, progress);
      break;
    case RecordingFormat::hdf5:
      convert_from_hdf5(in, out, options, summary, progress);
      break;
    default:
      convert_from_aedat4(in, out, options, summary, progress);
      break;
  }
  summary.bytes_in = fs::file_size(in);
  summary.bytes_out = fs::file_size(out);
  return summary;
}

}  // namespace tactile
