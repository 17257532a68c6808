#include "tactile/events/convert.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <span>

#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/event_csv.hpp"
#include "tactile/events/output_file.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile {
namespace fs = std::filesystem;
namespace {

constexpr std::array common_sizes{SensorSize{320, 240}, SensorSize{346, 260}, SensorSize{640, 480}};

/// What the options leave of an element's time.
class Cut {
 public:
  explicit Cut(const ConvertOptions& options)
      : from_(options.from.value_or(CameraTime::min())), to_(options.to), asked_(options.from || options.to) {
    if (to_ && *to_ <= from_)
      throw Error(fmt::format("the cut from {} to {} us is empty; expected an end behind the begin", us_of(from_), us_of(*to_)));
  }

  bool holds(CameraTime t) const { return t >= from_ && (!to_ || t < *to_); }
  bool asked() const { return asked_; }
  /// Whether the list of packets tells that nothing of this one is inside.
  bool misses(const PacketRecord& packet) const {
    return asked_ && packet.elements > 0 && (packet.last < from_ || (to_ && packet.first >= *to_));
  }
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
  CameraTime from_;
  std::optional<CameraTime> to_;
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

void check_options(const ConvertOptions& options, RecordingFormat from, RecordingFormat to) {
  if (from == RecordingFormat::csv && to == RecordingFormat::csv)
    throw Error("from CSV to CSV there is nothing to convert; expected one .aedat4 file");
  if (from == RecordingFormat::csv && !options.stream.empty())
    throw Error("--stream chooses among the streams of an AEDAT4 input; expected it left out for CSV");
  if (from != RecordingFormat::csv && (options.size || options.source))
    throw Error("--size and --source describe a CSV input; expected them left out for AEDAT4");
  if (to == RecordingFormat::csv && options.compression)
    throw Error("--compression is for an AEDAT4 output; expected it left out for CSV");
}

SensorSize size_that_holds(SensorSize extent) {
  const auto fits = [&](const SensorSize& size) { return extent.width <= size.width && extent.height <= size.height; };
  const auto* found = std::find_if(common_sizes.begin(), common_sizes.end(), fits);
  return found == common_sizes.end() ? extent : *found;
}

/// The stream with what the vendor's reader demands of it and not every writer gives.
Stream completed(Stream stream) {
  if (stream.name.empty()) stream.name = name_of(stream.type);
  if (stream.source.empty()) stream.source = "unknown";
  return stream;
}

/// Which streams of the input the output gets.
void choose_streams(const RecordingReader& recording, const ConvertOptions& options, ConvertSummary& summary) {
  const bool to_csv = summary.to == RecordingFormat::csv;
  const Stream* chosen = to_csv || !options.stream.empty() ? &event_stream(recording, options.stream) : nullptr;
  for (const Stream& stream : recording.streams()) {
    const bool is_chosen = chosen == nullptr || stream.id == chosen->id;
    const bool is_of_the_camera = chosen == nullptr || stream.source == chosen->source || stream.source.empty();
    const bool keeps =
        stream.type == StreamType::events ? is_chosen : !to_csv && is_of_the_camera && stream.type != StreamType::other;
    if (keeps) {
      summary.streams.push_back({stream, 0});
      if (stream.type == StreamType::events && !summary.size) summary.size = stream.size;
    } else {
      summary.left_out.push_back(stream);
    }
  }
  if (summary.streams.empty())
    throw Error(recording.file().string() + ": no stream that the output could hold; expected events, frames, imu or triggers");
}

void convert_from_aedat4(const fs::path& in, const fs::path& out, const ConvertOptions& options, ConvertSummary& summary,
                         const ProgressCallback& progress) {
  const Cut cut(options);
  RecordingReader recording(in, options.threads);
  choose_streams(recording, options, summary);
  const bool to_csv = summary.to == RecordingFormat::csv;

  WholeFile whole(out);
  std::optional<EventCsvWriter> csv;
  std::optional<RecordingWriter> writer;
  if (to_csv) {
    csv.emplace(whole.path());
  } else {
    summary.compression = options.compression.value_or(recording.compression());
    std::vector<Stream> streams;
    for (const ConvertedStream& kept : summary.streams) streams.push_back(completed(kept.stream));
    writer.emplace(whole.path(), std::move(streams), RecordingWriterOptions{.compression = *summary.compression});
  }

  TimeRange all, written;
  std::vector<Event> events_kept;
  std::vector<ImuSample> imu_kept;
  std::vector<Trigger> triggers_kept;
  for (const PacketRecord& packet : recording.packets()) {
    tell(progress, packet.payload_offset, recording.file_size(), out.filename().string());
    const auto kept = std::find_if(summary.streams.begin(), summary.streams.end(),
                                   [&](const ConvertedStream& s) { return s.stream.id == packet.stream_id; });
    if (kept == summary.streams.end()) continue;
    if (cut.misses(packet)) {
      all.add(packet.first);
      all.add(packet.last);
      continue;
    }
    const auto pass_on = [&]<class Element>(std::span<const Element> elements, std::vector<Element>& room, const auto& write) {
      all.add(elements);
      const std::span<const Element> inside = cut.of(elements, room);
      written.add(inside);
      kept->elements += inside.size();
      if (!inside.empty()) write(inside);
    };
    switch (kept->stream.type) {
      case StreamType::events:
        pass_on(std::span<const Event>(recording.read_events(packet)), events_kept, [&](std::span<const Event> inside) {
          to_csv ? csv->write(inside) : writer->write_events(packet.stream_id, inside);
        });
        break;
      case StreamType::imu:
        pass_on(std::span<const ImuSample>(recording.read_imu(packet)), imu_kept,
                [&](std::span<const ImuSample> inside) { writer->write_imu(packet.stream_id, inside); });
        break;
      case StreamType::triggers:
        pass_on(std::span<const Trigger>(recording.read_triggers(packet)), triggers_kept,
                [&](std::span<const Trigger> inside) { writer->write_triggers(packet.stream_id, inside); });
        break;
      case StreamType::frames:
        if (const auto frame = recording.read_frame(packet)) {
          all.add(frame->t);
          if (!cut.holds(frame->t)) break;
          written.add(frame->t);
          ++kept->elements;
          writer->write_frame(packet.stream_id, *frame);
        }
        break;
      case StreamType::other:
        break;
    }
  }
  if (cut.asked() && !written.first)
    throw Error(fmt::format("{}: the cut {} us leaves nothing; {}", in.string(), cut.text(), text_of(all)));

  summary.problems = recording.problems();
  summary.first = written.first;
  summary.last = written.last;
  if (to_csv) {
    summary.steps_back = csv->steps_back();
    csv->close();
  } else {
    writer->close();
  }
  whole.commit();
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
  const Cut cut(options);
  summary.size = options.size;
  if (!summary.size) {
    const SensorSize extent = extent_of(in, progress);
    if (extent.width == 0)
      throw Error(in.string() + ": no events to tell the sensor's size from; expected events, or --size WxH");
    summary.size = size_that_holds(extent);
    summary.size_guessed = true;
  }
  summary.compression = options.compression.value_or(Compression::lz4);
  summary.streams = {{event_stream_declaration(*summary.size, options.source.value_or("csv")), 0}};
  ConvertedStream& stream = summary.streams.front();

  EventCsvReader csv(in, summary.size);
  WholeFile whole(out);
  RecordingWriter writer(whole.path(), {stream.stream}, {.compression = *summary.compression});
  TimeRange all, written;
  std::vector<Event> room;
  const std::uint64_t passes = summary.size_guessed ? 2 : 1;
  for (auto events = csv.next(); !events.empty(); events = csv.next()) {
    const std::span<const Event> inside = cut.of(events, room);
    for (const auto& [range, part] : {std::pair(&all, events), std::pair(&written, inside)}) {  // ascending, so the ends suffice
      if (part.empty()) continue;
      range->add(part.front().t);
      range->add(part.back().t);
    }
    stream.elements += inside.size();
    writer.write_events(stream.stream.id, inside);
    tell(progress, csv.bytes_read() + (passes - 1) * csv.file_size(), passes * csv.file_size(), out.filename().string());
  }
  if (cut.asked() && !written.first)
    throw Error(fmt::format("{}: the cut {} us leaves nothing; {}", in.string(), cut.text(), text_of(all)));
  summary.first = written.first;
  summary.last = written.last;
  writer.close();
  whole.commit();
}

}  // namespace

RecordingFormat recording_format_of(const fs::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".aedat4") return RecordingFormat::aedat4;
  if (extension == ".csv") return RecordingFormat::csv;
  throw Error(fmt::format("{}: {}; expected .aedat4 or .csv", file.string(),
                          extension.empty() ? "no extension that names a format" : "unknown extension '" + extension + "'"));
}

ConvertSummary convert_recording(const fs::path& in, const fs::path& out, const ConvertOptions& options,
                                 const ProgressCallback& progress) {
  ConvertSummary summary;
  summary.from = recording_format_of(in);
  summary.to = recording_format_of(out);
  check_options(options, summary.from, summary.to);
  if (!fs::is_regular_file(in)) throw Error(in.string() + ": no such file; expected a recording");
  check_target(out, in, options.replace);
  if (summary.from == RecordingFormat::csv) {
    convert_from_csv(in, out, options, summary, progress);
  } else {
    convert_from_aedat4(in, out, options, summary, progress);
  }
  summary.bytes_in = fs::file_size(in);
  summary.bytes_out = fs::file_size(out);
  return summary;
}

}  // namespace tactile
