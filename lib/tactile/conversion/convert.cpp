#include "tactile/conversion/convert.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <memory>
#include <span>
#include <utility>

#include "tactile/conversion/hdf5_recording.hpp"
#include "tactile/conversion/recording_output.hpp"
#include "tactile/conversion/time_cut.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/text.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/camera_streams.hpp"
#include "tactile/events/event_csv.hpp"
#include "tactile/events/output_file.hpp"
#include "tactile/events/packet_contents.hpp"
#include "tactile/events/recording_writer.hpp"
#include "tactile/recipes/recipe_stream.hpp"

namespace tactile::conversion {
namespace fs = std::filesystem;
namespace {

constexpr std::array common_sizes{events::SensorSize{320, 240}, events::SensorSize{346, 260}, events::SensorSize{640, 480},
                                  events::SensorSize{1280, 720}};

/// The times of some elements.
struct Times {
  CameraTime first, last;  ///< the earliest and the latest
  bool ascending = true;
};

/// @param elements  one at least
template <class Element>
Times times_of(std::span<const Element> elements) {
  const auto is_earlier = [](const Element& a, const Element& b) { return a.t < b.t; };
  if (std::is_sorted(elements.begin(), elements.end(), is_earlier)) return {elements.front().t, elements.back().t};
  const auto [earliest, latest] = std::minmax_element(elements.begin(), elements.end(), is_earlier);
  return {earliest->t, latest->t, false};
}

/// The earliest and the latest time so far.
struct TimesSeen {
  std::optional<CameraTime> first, last;

  void add(const Times& times) {
    first = std::min(first.value_or(times.first), times.first);
    last = std::max(last.value_or(times.last), times.last);
  }
};

std::string text_of(const TimesSeen& range) {
  return range.first ? fmt::format("its elements lie from {} to {} us", us_of(*range.first), us_of(*range.last))
                     : std::string("the recording is empty");
}

bool can_hold(RecordingFormat format, events::StreamType type) {
  if (holds_one_stream(format)) return type == events::StreamType::events;
  if (format == RecordingFormat::hdf5) return type != events::StreamType::other && type != events::StreamType::frames;
  return type != events::StreamType::other;
}

void check_options(const ConvertOptions& options, RecordingFormat from, RecordingFormat to) {
  if (from == RecordingFormat::npz)
    throw Error("NPZ can be written, but not read; expected an input that ends in .aedat4, .raw, .csv or .h5");
  if (to == RecordingFormat::raw)
    throw Error("RAW can be read, but not written; expected an output that ends in .aedat4, .csv, .h5 or .npz");
  if (from == RecordingFormat::csv && !options.streams.empty())
    throw Error("--stream selects a stream of an AEDAT4 or HDF5 input; omit it for CSV");
  if ((from == RecordingFormat::aedat4 || from == RecordingFormat::raw) && (options.size || options.source))
    throw Error(fmt::format("--size and --source describe a CSV or HDF5 input; omit them for {}", name_of(from)));
  if (from != RecordingFormat::csv && (!options.csv.columns.empty() || options.csv.time_unit))
    throw Error(fmt::format("--columns and --time-unit describe a CSV input; omit them for {}", name_of(from)));
  if (to != RecordingFormat::aedat4 && options.compression)
    throw Error(fmt::format("--compression is for an AEDAT4 output; omit it for {}", name_of(to)));
  if (holds_one_stream(to) && options.streams.size() > 1)
    throw Error(fmt::format("{} streams for one {}; expected one --stream, because streams are never merged",
                            options.streams.size(), name_of(to)));
  if (options.crop && (options.crop->width < 1 || options.crop->height < 1 || options.crop->x < 0 || options.crop->y < 0))
    throw Error("the crop is empty or begins outside the sensor; expected X,Y,WxH with X and Y from 0, W and H from 1");
}

events::SensorSize size_that_holds(events::SensorSize extent) {
  const auto fits = [&](const events::SensorSize& size) { return extent.width <= size.width && extent.height <= size.height; };
  const auto* found = std::find_if(common_sizes.begin(), common_sizes.end(), fits);
  return found == common_sizes.end() ? extent : *found;
}

/// Selects the input streams for the output. The crop determines their size.
void choose_streams(std::span<const events::Stream> streams, const fs::path& in, const ConvertOptions& options,
                    ConvertSummary& summary) {
  std::vector<const events::Stream*> chosen;
  for (const std::string& choice : options.streams) chosen.push_back(&events::event_stream(streams, in.string(), choice));
  if (chosen.empty() && holds_one_stream(summary.to)) chosen.push_back(&events::event_stream(streams, in.string()));
  for (const events::Stream& stream : streams) {
    const bool is_wanted = chosen.empty() || std::any_of(chosen.begin(), chosen.end(), [&](const events::Stream* of_events) {
                             return events::belongs_to(stream, *of_events);
                           });
    if (!is_wanted || !can_hold(summary.to, stream.type)) {
      summary.left_out.push_back(stream);
      continue;
    }
    events::Stream kept = completed(stream);
    if (options.crop && (stream.type == events::StreamType::events || stream.type == events::StreamType::frames)) {
      const PixelRegion& crop = *options.crop;
      if (stream.size && (crop.width > stream.size->width - crop.x || crop.height > stream.size->height - crop.y)) {
        throw Error(fmt::format("{}: the crop {},{},{}x{} exceeds the {}x{} pixels of stream {}; expected a crop inside them",
                                in.string(), crop.x, crop.y, crop.width, crop.height, stream.size->width, stream.size->height,
                                stream.id));
      }
      kept.size = events::SensorSize{crop.width, crop.height};
    }
    if (stream.type == events::StreamType::events && !summary.size) summary.size = kept.size;
    summary.streams.push_back({std::move(kept), 0});
  }
  if (summary.streams.empty())
    throw Error(in.string() + ": has no stream that the output format supports; expected events, frames, imu or triggers");
}

/// Passes every element from input to output: cut, cropped, counted.
class Passage {
 public:
  Passage(const fs::path& in, const fs::path& out, const ConvertOptions& options, ConvertSummary& summary)
      : in_(in),
        cut_(options),
        crop_(options.crop),
        recipes_(options.recipes),
        summary_(summary),
        whole_(out, options.replace ? IfThere::replace : IfThere::refuse),
        output_(open_output(whole_.path(), in, summary, options.threads)) {}

  /// Gives the time of the first element. Without this call, it is the time of the first that is passed.
  void begin_at(CameraTime first) { cut_.begin_at(first); }

  /// The output stream of this stream's elements; nullptr if they are omitted.
  ConvertedStream* output_stream(std::int32_t stream_id) {
    const auto found = std::find_if(summary_.streams.begin(), summary_.streams.end(),
                                    [&](const ConvertedStream& s) { return s.stream.id == stream_id; });
    return found == summary_.streams.end() ? nullptr : &*found;
  }
  void pass(ConvertedStream& to, std::span<const events::Event> events) {
    note(events);
    std::span<const events::Event> inside = cut_.of(events, events_kept_);
    if (crop_) {
      events_cropped_.clear();
      crop_events(inside, *crop_, events_cropped_);
      summary_.cropped_events += inside.size() - events_cropped_.size();
      inside = events_cropped_;
    }
    if (!recipes_.empty()) {
      events_worsened_.clear();
      worsening_of(to).push(inside, events_worsened_);
      inside = events_worsened_;
    }
    hand_over(to, inside);
  }
  void pass(ConvertedStream& to, std::span<const events::ImuSample> samples) {
    note(samples);
    hand_over(to, cut_.of(samples, imu_kept_));
  }
  void pass(ConvertedStream& to, std::span<const events::Trigger> triggers) {
    note(triggers);
    hand_over(to, cut_.of(triggers, triggers_kept_));
  }
  void pass(ConvertedStream& to, const events::Frame& frame) {
    note(std::span(&frame, 1));
    if (!cut_.holds(frame.t)) return;
    const std::optional<events::Frame> part =
        crop_ ? cropped(frame, *crop_, events::bytes_per_pixel(frame.format)) : std::nullopt;
    if (crop_ && !part) {
      ++summary_.cropped_frames;
      return;
    }
    note_times(to, std::span(&frame, 1));
    ++to.elements;
    output_->write(to.stream.id, crop_ ? *part : frame);
  }

  void finish() {
    for (auto& [id, stream] : worsening_) {
      events_worsened_.clear();
      stream.finish(events_worsened_);
      hand_over(*output_stream(id), std::span<const events::Event>(events_worsened_));
    }
    if (cut_.is_limited() && !written_.first && summary_.cropped_events == 0)
      throw Error(fmt::format("{}: the cut {} us contains no element; {}. A '+' before a time counts from the first element",
                              in_.string(), cut_.text(), text_of(all_)));
    const bool any = std::any_of(summary_.streams.begin(), summary_.streams.end(), [](const ConvertedStream& s) {
      return s.elements > 0 && (s.stream.type == events::StreamType::events || s.stream.type == events::StreamType::frames);
    });
    if (summary_.cropped_events > 0 && !any) {
      throw Error(fmt::format("{}: the crop contains none of {} events; expected a region with events", in_.string(),
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
    if (!elements.empty()) all_.add(times_of(elements));
    if (all_.first) cut_.begin_at(*all_.first);
  }

  template <class Element>
  void hand_over(ConvertedStream& to, std::span<const Element> inside) {
    if (inside.empty()) return;
    note_times(to, inside);
    to.elements += inside.size();
    output_->write(to.stream.id, inside);
  }

  /// The recipes at work on this stream.
  recipes::RecipeStream& worsening_of(const ConvertedStream& to) {
    const auto found = worsening_.find(to.stream.id);
    if (found != worsening_.end()) return found->second;
    if (!to.stream.size)
      throw Error(fmt::format("{}: stream {} has no sensor size; expected one, or no recipes", in_.string(), to.stream.id));
    return worsening_.emplace(to.stream.id, recipes::RecipeStream(recipes_, *to.stream.size)).first->second;
  }

  /// Records the times of elements that are about to be written.
  /// @throws Error  that names the input, if a time steps back and the output is a recording, whose times never fall
  template <class Element>
  void note_times(const ConvertedStream& to, std::span<const Element> elements) {
    const Times times = times_of(elements);
    written_.add(times);
    if (holds_one_stream(summary_.to)) return;
    CameraTime& newest = newest_.try_emplace(to.stream.id, elements.front().t).first->second;
    if (times.ascending && times.first >= newest) {
      newest = times.last;
      return;
    }
    for (const Element& element : elements) {
      if (element.t < newest) {
        throw Error(
            fmt::format("{}: stream {} goes back in time, from {} to {} us; expected times that never fall: CSV and NPZ "
                        "keep events as they are; --from-us above {} or --to-us up to {} omits the step",
                        in_.string(), to.stream.id, us_of(newest), us_of(element.t), us_of(newest), us_of(element.t)));
      }
      newest = element.t;
    }
  }

  fs::path in_;
  TimeCut cut_;
  std::optional<PixelRegion> crop_;
  std::span<const recipes::Recipe> recipes_;
  ConvertSummary& summary_;
  WholeFile whole_;
  std::unique_ptr<RecordingOutput> output_;
  TimesSeen all_, written_;
  std::map<std::int32_t, CameraTime> newest_;                ///< written of each stream
  std::map<std::int32_t, recipes::RecipeStream> worsening_;  ///< of each stream of events
  std::vector<events::Event> events_kept_, events_cropped_, events_worsened_;
  std::vector<events::ImuSample> imu_kept_;
  std::vector<events::Trigger> triggers_kept_;
};

void convert_from_packets(const fs::path& in, const fs::path& out, const ConvertOptions& options, ConvertSummary& summary,
                          const ProgressCallback& progress) {
  events::RecordingReader recording(in, options.threads);
  choose_streams(recording.streams(), in, options, summary);
  if (summary.to == RecordingFormat::aedat4) {
    const bool is_aedat4 = recording.encoding() == events::RecordingEncoding::aedat4;
    summary.compression = options.compression.value_or(is_aedat4 ? recording.compression() : events::Compression::lz4);
  }
  Passage passage(in, out, options, summary);
  std::optional<CameraTime> first;
  for (const events::PacketRecord& packet : recording.packets()) {
    if (packet.elements > 0 && passage.output_stream(packet.stream_id) != nullptr)
      first = std::min(first.value_or(packet.first), packet.first);
  }
  if (first) passage.begin_at(*first);
  for (const events::PacketRecord& packet : recording.packets()) {
    report_progress(progress, packet.payload_offset, recording.file_size(), out.filename().string());
    ConvertedStream* const to = passage.output_stream(packet.stream_id);
    if (to == nullptr) continue;  // all packets are read, because the data table's times may be wrong
    switch (to->stream.type) {
      case events::StreamType::events:
        passage.pass(*to, std::span<const events::Event>(recording.read_events(packet)));
        break;
      case events::StreamType::imu:
        passage.pass(*to, std::span<const events::ImuSample>(recording.read_imu(packet)));
        break;
      case events::StreamType::triggers:
        passage.pass(*to, std::span<const events::Trigger>(recording.read_triggers(packet)));
        break;
      case events::StreamType::frames:
        if (const auto frame = recording.read_frame(packet)) passage.pass(*to, *frame);
        break;
      case events::StreamType::other:
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
  if (summary.to == RecordingFormat::aedat4) summary.compression = options.compression.value_or(events::Compression::lz4);
  Passage passage(in, out, options, summary);
  std::vector<std::int32_t> ids;
  for (const ConvertedStream& kept : summary.streams) ids.push_back(kept.stream.id);
  const auto pass = [&](const events::Stream& stream, const auto& elements) {
    passage.pass(*passage.output_stream(stream.id), elements);
  };
  recording.read(ids, {.events = pass, .imu = pass, .triggers = pass}, progress);
  passage.finish();
}

/// The smallest sensor that contains a CSV's events, 0x0 without events. Checks every line.
events::SensorSize extent_of(const fs::path& in, const events::EventCsvOptions& options, const ProgressCallback& progress) {
  events::EventCsvReader csv(in, std::nullopt, options);
  int last_x = -1, last_y = -1;
  for (auto events = csv.next(); !events.empty(); events = csv.next()) {
    for (const events::Event& event : events) {
      last_x = std::max<int>(last_x, event.x);
      last_y = std::max<int>(last_y, event.y);
    }
    report_progress(progress, csv.bytes_read(), 2 * csv.file_size(), in.filename().string());
  }
  return {last_x + 1, last_y + 1};
}

void convert_from_csv(const fs::path& in, const fs::path& out, const ConvertOptions& options, ConvertSummary& summary,
                      const ProgressCallback& progress) {
  std::optional<events::SensorSize> size = options.size;
  if (!size) {
    const events::SensorSize extent = extent_of(in, options.csv, progress);
    if (extent.width == 0)
      throw Error(in.string() + ": has no events, so the sensor's size is unknown; expected events, or --size WxH");
    size = size_that_holds(extent);
    summary.size_guessed = true;
  }
  const events::Stream stream = events::event_stream_declaration(*size, options.source.value_or("csv"));
  choose_streams({&stream, 1}, in, options, summary);
  if (summary.to == RecordingFormat::aedat4) summary.compression = options.compression.value_or(events::Compression::lz4);

  events::EventCsvReader csv(in, size, options.csv);
  summary.time_unit = csv.time_unit();
  summary.time_unit_guessed = csv.time_unit_guessed();
  Passage passage(in, out, options, summary);
  const std::uint64_t passes = summary.size_guessed ? 2 : 1;
  for (auto events = csv.next(); !events.empty(); events = csv.next()) {
    passage.pass(summary.streams.front(), events);
    report_progress(progress, csv.bytes_read() + (passes - 1) * csv.file_size(), passes * csv.file_size(),
                    out.filename().string());
  }
  summary.overflows = csv.overflows();
  passage.finish();
}

}  // namespace

std::string_view name_of(RecordingFormat format) {
  constexpr std::array<std::string_view, 5> names{"AEDAT4", "CSV", "HDF5", "NPZ", "RAW"};
  return names.at(static_cast<std::size_t>(format));
}

std::string lower_extension(const fs::path& file) { return lower_case(file.extension().string()); }

RecordingFormat recording_format_of(const fs::path& file) {
  const std::string extension = lower_extension(file);
  if (extension == ".aedat4") return RecordingFormat::aedat4;
  if (extension == ".csv" || extension == ".txt") return RecordingFormat::csv;
  if (extension == ".h5" || extension == ".hdf5") return RecordingFormat::hdf5;
  if (extension == ".npz") return RecordingFormat::npz;
  if (extension == ".raw") return RecordingFormat::raw;
  throw Error(fmt::format("{}: {}; expected .aedat4, .csv, .h5 or .npz, or .raw as input", file.string(),
                          extension.empty() ? "no extension that names a format" : "unknown extension '" + extension + "'"));
}

ConvertSummary convert_recording(const fs::path& in, const fs::path& out, const ConvertOptions& options,
                                 const ProgressCallback& progress) {
  ConvertSummary summary;
  summary.from = recording_format_of(in);
  summary.to = recording_format_of(out);
  check_options(options, summary.from, summary.to);
  if (!fs::exists(in)) throw Error(in.string() + ": no such file; expected a recording");
  if (!fs::is_regular_file(in)) throw Error(in.string() + ": is not a regular file; expected a recording");
  events::check_target(out, in, options.replace);
  switch (summary.from) {
    case RecordingFormat::csv:
      convert_from_csv(in, out, options, summary, progress);
      break;
    case RecordingFormat::hdf5:
      convert_from_hdf5(in, out, options, summary, progress);
      break;
    default:
      convert_from_packets(in, out, options, summary, progress);
      break;
  }
  summary.bytes_in = fs::file_size(in);
  summary.bytes_out = fs::file_size(out);
  return summary;
}

}  // namespace tactile::conversion
