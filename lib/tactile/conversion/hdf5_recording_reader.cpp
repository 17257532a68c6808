#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <type_traits>

#include "tactile/conversion/hdf5_recording.hpp"
#include "tactile/conversion/hdf5_recording_layout.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/events/recording_header.hpp"
#include "tactile/hdf5/hdf5_objects.hpp"
#include "tactile/hdf5/read_apart.hpp"

namespace tactile::conversion {
namespace fs = std::filesystem;
namespace h5 = hdf5;
using hdf5_layout::chunk_rows;
using hdf5_layout::groups;

namespace {

constexpr hsize_t most_chunk_rows = hsize_t{16} << 20;
constexpr microseconds piece_span{10'000};  // the streams are interleaved this finely

/// A column that is read, a block of whole chunks at a time, so that no chunk is decompressed twice.
template <class T>
class ColumnIn {
 public:
  void open(hid_t group, const std::string& name, hsize_t row_width, const std::string& group_name) {
    where_ = group_name + "/" + name;
    width_ = row_width;
    if (!h5::has_member(group, name)) throw Error(fmt::format("{}: is missing; expected a column of {}", where_, kind()));
    if (!h5::linked_file(group, name).empty())
      throw Error(where_ + ": lies in another file; expected the whole recording in one file");
    table_ = h5::open_table(group, name, where_);
    h5::check_filters(table_, where_);
    const h5::Id type(H5Dget_type(table_), H5Tclose);
    const H5T_class_t stored = H5Tget_class(type);
    const bool fits = std::is_floating_point_v<T> ? stored == H5T_FLOAT : stored == H5T_INTEGER || stored == H5T_ENUM;
    if (!fits) throw Error(fmt::format("{}: holds another kind of values; expected {}", where_, kind()));
    clamps_ = stored == H5T_INTEGER && H5Tget_size(type) >= 8 && H5Tget_sign(type) == H5T_SGN_NONE;
    const std::vector<hsize_t> shape = h5::shape_of(table_, where_);
    if (shape.size() != (width_ == 1 ? 1U : 2U) || (width_ > 1 && shape[1] != width_)) {
      throw Error(
          fmt::format("{}: has another shape; expected [rows{}]", where_, width_ == 1 ? "" : fmt::format(", {}", width_)));
    }
    rows_ = shape[0];
    h5::check_stored_size(table_, where_);
    const hsize_t chunk = h5::rows_per_chunk(table_, where_);
    if (chunk > most_chunk_rows)
      throw Error(fmt::format("{}: has {} rows in a chunk; expected at most {}", where_, chunk, most_chunk_rows));
    block_ = chunk == 0 ? chunk_rows : chunk * std::max<hsize_t>(1, chunk_rows / chunk);
  }

  hsize_t rows() const { return rows_; }
  const std::string& where() const { return where_; }

  /// The values of a row, valid until the next call. Rows must be requested in ascending order.
  const T* at(hsize_t row) {
    if (row >= end_) load(row);
    return &values_[(row - begin_) * width_];
  }

 private:
  static std::string_view kind() { return std::is_floating_point_v<T> ? "floating-point numbers" : "whole numbers"; }

  void load(hsize_t row) {
    begin_ = row - row % block_;
    end_ = std::min(rows_, begin_ + block_);
    values_.resize((end_ - begin_) * width_);
    h5::read_rows(table_, h5::memory_type<T>(), values_.data(), begin_, end_ - begin_, where_);
    const auto beyond = clamps_ ? std::find(values_.begin(), values_.end(), std::numeric_limits<T>::max()) : values_.end();
    if (beyond != values_.end()) {
      throw Error(fmt::format("{}: row {} is beyond {}; expected numbers within", where_,
                              begin_ + static_cast<hsize_t>(beyond - values_.begin()), std::numeric_limits<T>::max()));
    }
  }

  h5::Id table_;
  std::string where_;
  hsize_t width_ = 1, rows_ = 0, block_ = 1;
  hsize_t begin_ = 0, end_ = 0;  ///< of the block in memory
  bool clamps_ = false;          ///< HDF5 reads a value beyond T as the largest T
  std::vector<T> values_;
};

struct StreamIn {
  events::Stream stream;
  hsize_t rows = 0, next = 0;
  CameraTime previous = CameraTime::min();
  ColumnIn<std::int64_t> t;
  ColumnIn<std::int32_t> x, y, on, type;
  ColumnIn<float> temperature, acceleration, angular_rate, magnetic_field;

  bool ended() const { return next == rows; }
  CameraTime next_time() { return camera_time(*t.at(next)); }

  /// The time of the row at `next`. @throws Error  if an earlier row has a later time
  CameraTime take_time() {
    const CameraTime at = next_time();
    if (at < previous) {
      throw Error(fmt::format("{}: time goes back in row {}, from {} to {} us; expected times that never fall", t.where(), next,
                              us_of(previous), us_of(at)));
    }
    previous = at;
    return at;
  }
  std::int32_t take(ColumnIn<std::int32_t>& column, std::int32_t least, std::int32_t most) const {
    const std::int32_t value = *column.at(next);
    if (value < least || value > most)
      throw Error(fmt::format("{}: row {} is {}; expected {} to {}", column.where(), next, value, least, most));
    return value;
  }
};

std::optional<std::int64_t> number_of(hid_t object, const std::string& name, const std::string& where) {
  return h5::has_attribute(object, name) ? std::optional(h5::read_number(object, name, where)) : std::nullopt;
}
std::optional<std::string> text_of(hid_t object, const std::string& name, const std::string& where) {
  return h5::has_attribute(object, name) ? std::optional(h5::read_text_attribute(object, name, where)) : std::nullopt;
}

void refuse_dataset(hid_t file, const std::string& name) {
  const bool is_one =
      h5::has_attribute(file, "manifest_sha256") || h5::has_member(file, "runs") ||
      (h5::is_group(file, "events") && h5::has_attribute(h5::open_group(file, "events", name), "manifest_sha256"));
  if (is_one) {
    throw Error(name + ": is the events file of a dataset, with many runs; expected a recording, such as " +
                "the events.aedat4 of one of its runs");
  }
}

/// For a file of another program: its filters are the first thing that it lacks here.
/// @throws Error  that names the filter, if a table in the group, or in a group of it, needs one that this HDF5 lacks
void check_all_filters(hid_t group, const std::string& where, bool is_root = false) {
  for (const std::string& member : h5::members_of(group)) {
    const std::string place = fmt::format("{}{}{}", where, is_root ? ": /" : "/", member);
    if (!h5::linked_file(group, member).empty()) continue;
    if (h5::is_group(group, member)) {
      if (is_root) check_all_filters(h5::open_group(group, member, where), place);
      continue;
    }
    const h5::Id table(H5Dopen2(group, member.c_str(), H5P_DEFAULT), H5Dclose);
    if (table >= 0) h5::check_filters(table, place);
  }
}

/// "p, t, x, y": the begin of it, because a file may have any number of members.
std::string names_of(const std::vector<std::string>& members) {
  std::string list;
  for (const std::string& member : members) list += (list.empty() ? "" : ", ") + member.substr(0, 40);
  return list.empty() ? "nothing" : list.substr(0, 200);
}

/// What the reading process sends.
enum Sent : std::uint32_t { of_streams, of_events, of_imu, of_triggers, of_progress };

template <class T>
std::vector<T> values_in(std::span<const std::byte> bytes) {
  static_assert(std::is_trivially_copyable_v<T>);
  std::vector<T> values(bytes.size() / sizeof(T));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  return values;
}

/// As CBOR, because texts may contain any bytes.
std::vector<std::uint8_t> packed(const events::Stream& stream) {
  nlohmann::json size;
  if (stream.size) size = {stream.size->width, stream.size->height};
  return nlohmann::json::to_cbor(nlohmann::json::array(
      {stream.id, static_cast<int>(stream.type), stream.type_identifier, stream.source, stream.name, size, stream.info}));
}

events::Stream unpacked(std::span<const std::byte> bytes) {
  const auto* begin = reinterpret_cast<const std::uint8_t*>(bytes.data());
  const nlohmann::json json = nlohmann::json::from_cbor(begin, begin + bytes.size());
  events::Stream stream;
  stream.id = json.at(0).get<std::int32_t>();
  stream.type = static_cast<events::StreamType>(json.at(1).get<int>());
  stream.type_identifier = json.at(2).get<std::string>();
  stream.source = json.at(3).get<std::string>();
  stream.name = json.at(4).get<std::string>();
  if (!json.at(5).is_null()) stream.size = events::SensorSize{json.at(5).at(0).get<int>(), json.at(5).at(1).get<int>()};
  stream.info = json.at(6).get<decltype(stream.info)>();
  return stream;
}

/// An open recording, in the reading process.
struct OpenRecording {
  std::string name;
  h5::Id file;
  std::vector<StreamIn> inputs;
  std::vector<events::Stream> streams;
  bool is_given_size_used = false;

  events::SensorSize size_of_events(hid_t group, const std::string& where, std::optional<events::SensorSize> given) {
    std::optional<std::int64_t> width = number_of(group, "width", where), height = number_of(group, "height", where);
    if (!width || !height) {
      width = number_of(file, "sensor_width", name);
      height = number_of(file, "sensor_height", name);
    }
    if ((!width || !height) && given) {
      is_given_size_used = true;
      return *given;
    }
    if (!width || !height) {
      throw Error(name + ": has no sensor size; expected the attributes sensor_width and sensor_height, or --size WxH");
    }
    if (*width < 1 || *height < 1 || *width > events::most_side || *height > events::most_side) {
      throw Error(fmt::format("{}: declares a sensor of {}x{} pixels; expected 1 to {} in each direction", name, *width, *height,
                              events::most_side));
    }
    return {static_cast<int>(*width), static_cast<int>(*height)};
  }

  /// @throws Error  if another program wrote the events
  static void check_columns(const h5::Id& group, const std::string& where) {
    if (h5::has_member(group, "t_us")) return;
    check_all_filters(group, where);
    throw Error(
        fmt::format("{}: has the columns of another program, {}; expected those that 'tactile convert' writes: t_us, x, y and on",
                    where, names_of(h5::members_of(group))));
  }

  void add(events::StreamType type, const std::string& member, std::optional<events::SensorSize> size,
           const std::optional<std::string>& source) {
    const std::string where = name + ": /" + member;
    if (!h5::linked_file(file, member).empty())
      throw Error(where + ": lies in another file; expected the whole recording in one file");
    if (!h5::is_group(file, member)) throw Error(where + ": is not a group; expected a group with a table for each column");
    const h5::Id group = h5::open_group(file, member, name);
    StreamIn& in = inputs.emplace_back();
    in.stream.type = type;
    in.stream.type_identifier = events::identifier_of(type);

    const std::size_t cut = member.find('_');
    const std::int64_t plain_id = type == events::StreamType::events ? 0
                                  : type == events::StreamType::imu  ? 2
                                                                     : 3;  // as the vendor counts
    const std::int64_t named_id = cut == std::string::npos ? plain_id : whole_number_in(member.substr(cut + 1)).value_or(-1);
    const std::int64_t id = number_of(group, "stream_id", where).value_or(named_id);
    if (id < 0 || id > std::numeric_limits<std::int32_t>::max())
      throw Error(fmt::format("{}: is stream {}; expected a whole number from 0 on", where, id));
    in.stream.id = static_cast<std::int32_t>(id);
    for (const events::Stream& other : streams) {
      if (other.id == in.stream.id)
        throw Error(fmt::format("{}: is stream {}, as another one; expected a different id for each", where, id));
    }
    in.stream.name = text_of(group, "name", where).value_or(std::string(name_of(type)));
    std::optional<std::string> declared = text_of(group, "source", where);
    if (!declared) declared = text_of(file, "source", name);
    if (declared && source) throw Error(name + ": declares the camera '" + *declared + "'; omit --source");
    in.stream.source = declared ? *declared : source.value_or("hdf5");
    const nlohmann::ordered_json info =
        nlohmann::ordered_json::parse(text_of(group, "info", where).value_or("{}"), nullptr, false);
    if (info.is_object()) {
      for (const auto& [key, value] : info.items())
        in.stream.info.emplace_back(key, value.is_string() ? value.get<std::string>() : value.dump());
    }
    if (type == events::StreamType::events) check_columns(group, where);
    in.t.open(group, "t_us", 1, where);
    in.rows = in.t.rows();
    const auto open = [&](auto& column, const char* called, hsize_t width) {
      column.open(group, called, width, where);
      if (column.rows() != in.rows) {
        throw Error(fmt::format("{}: has {} rows, and t_us has {}; expected columns of one length", column.where(), column.rows(),
                                in.rows));
      }
    };
    if (type == events::StreamType::events) {
      in.stream.size = size_of_events(group, where, size);
      open(in.x, "x", 1);
      open(in.y, "y", 1);
      open(in.on, "on", 1);
    } else if (type == events::StreamType::imu) {
      open(in.temperature, "temperature_c", 1);
      open(in.acceleration, "acceleration_g", 3);
      open(in.angular_rate, "angular_rate_dps", 3);
      open(in.magnetic_field, "magnetic_field_ut", 3);
    } else {
      open(in.type, "type", 1);
    }
    streams.push_back(in.stream);
  }

  void open(const fs::path& path, std::optional<events::SensorSize> size, const std::optional<std::string>& source) {
    name = path.string();
    file = h5::open_file(path, false);
    refuse_dataset(file, name);
    const std::vector<std::string> members = h5::members_of(file);
    inputs.reserve(members.size());  // pointers to columns stay valid
    for (const auto& [type, group] : groups) {
      for (const std::string& member : members) {
        const bool is_further = member.size() > group.size() && member.starts_with(group) && member[group.size()] == '_';
        if (member == group || is_further) add(type, member, size, source);
      }
    }
    const auto sized = std::find_if(streams.begin(), streams.end(), [](const events::Stream& s) { return s.size.has_value(); });
    if (size && !is_given_size_used && sized != streams.end()) {
      throw Error(
          fmt::format("{}: declares a sensor of {}x{} pixels; omit --size", name, sized->size->width, sized->size->height));
    }
    if (inputs.empty()) {
      check_all_filters(file, name, true);
      throw Error(fmt::format("{}: contains no recording, only {}; expected the group /events with t_us, x, y and on", name,
                              names_of(members)));
    }
  }

  /// Sends the elements of these streams in pieces, and the progress after each piece.
  void read(std::span<const std::int32_t> stream_ids, const h5::Send& send) {
    std::vector<StreamIn*> left;
    std::uint64_t total = 0, done = 0;
    for (StreamIn& in : inputs) {
      if (std::find(stream_ids.begin(), stream_ids.end(), in.stream.id) == stream_ids.end()) continue;
      left.push_back(&in);
      total += in.rows;
    }

    std::vector<events::Event> events;
    std::vector<events::ImuSample> samples;
    std::vector<events::Trigger> triggers;
    const auto xyz = [](ColumnIn<float>& column, hsize_t row, float(&into)[3]) { std::copy_n(column.at(row), 3, into); };
    for (std::erase_if(left, [](const StreamIn* in) { return in->ended(); }); !left.empty();
         std::erase_if(left, [](const StreamIn* in) { return in->ended(); })) {
      std::sort(left.begin(), left.end(), [](StreamIn* a, StreamIn* b) { return a->next_time() < b->next_time(); });
      StreamIn& in = *left.front();
      const CameraTime until = left.size() > 1 ? after(left[1]->next_time(), piece_span) : CameraTime::max();
      const hsize_t end = std::min(in.rows, in.next + chunk_rows);
      const hsize_t begin = in.next;
      events.clear();
      samples.clear();
      triggers.clear();
      for (; in.next < end && in.next_time() <= until; ++in.next) {
        const CameraTime t = in.take_time();
        if (in.stream.type == events::StreamType::events) {
          events::Event event{.t = t};
          event.x = static_cast<std::int16_t>(in.take(in.x, 0, in.stream.size->width - 1));
          event.y = static_cast<std::int16_t>(in.take(in.y, 0, in.stream.size->height - 1));
          event.on = static_cast<std::uint8_t>(in.take(in.on, 0, 1));
          events.push_back(event);
        } else if (in.stream.type == events::StreamType::imu) {
          events::ImuSample& sample = samples.emplace_back();
          sample.t = t;
          sample.temperature_c = *in.temperature.at(in.next);
          xyz(in.acceleration, in.next, sample.acceleration_g);
          xyz(in.angular_rate, in.next, sample.angular_rate_dps);
          xyz(in.magnetic_field, in.next, sample.magnetic_field_ut);
        } else {
          triggers.push_back({.t = t, .type = static_cast<std::int8_t>(in.take(in.type, -128, 127))});
        }
      }
      const auto place = static_cast<std::uint32_t>(&in - inputs.data());
      if (!events.empty()) send(of_events, place, std::as_bytes(std::span(events)));
      if (!samples.empty()) send(of_imu, place, std::as_bytes(std::span(samples)));
      if (!triggers.empty()) send(of_triggers, place, std::as_bytes(std::span(triggers)));
      done += in.next - begin;
      const std::array progress{done, total};
      send(of_progress, 0, std::as_bytes(std::span(progress)));
    }
  }
};

}  // namespace

struct Hdf5RecordingReader::State {
  fs::path file;
  std::optional<events::SensorSize> size;
  std::optional<std::string> source;
  std::vector<events::Stream> streams;
};

Hdf5RecordingReader::Hdf5RecordingReader(const fs::path& file, std::optional<events::SensorSize> size,
                                         const std::optional<std::string>& source)
    : state_(std::make_unique<State>(State{file, size, source, {}})) {
  const auto open = [&](const h5::Send& send) {
    OpenRecording recording;
    recording.open(file, size, source);
    for (const events::Stream& stream : recording.streams) {
      const std::vector<std::uint8_t> bytes = packed(stream);
      send(of_streams, 0, std::as_bytes(std::span(bytes)));
    }
  };
  h5::read_apart(file, open, [&](std::uint32_t, std::uint32_t, std::span<const std::byte> bytes) {
    state_->streams.push_back(unpacked(bytes));
  });
}
Hdf5RecordingReader::~Hdf5RecordingReader() = default;
Hdf5RecordingReader::Hdf5RecordingReader(Hdf5RecordingReader&&) noexcept = default;
Hdf5RecordingReader& Hdf5RecordingReader::operator=(Hdf5RecordingReader&&) noexcept = default;

std::span<const events::Stream> Hdf5RecordingReader::streams() const { return state_->streams; }

void Hdf5RecordingReader::read(std::span<const std::int32_t> stream_ids, const Taker& taker, const ProgressCallback& progress) {
  const auto work = [&](const h5::Send& send) {
    OpenRecording recording;
    recording.open(state_->file, state_->size, state_->source);
    recording.read(stream_ids, send);
  };
  h5::read_apart(state_->file, work, [&](std::uint32_t kind, std::uint32_t place, std::span<const std::byte> bytes) {
    if (kind == of_progress) {
      const auto counts = values_in<std::uint64_t>(bytes);
      return report_progress(progress, counts.at(0), counts.at(1), state_->file.filename().string());
    }
    const events::Stream& stream = state_->streams.at(place);
    if (kind == of_events) taker.events(stream, values_in<events::Event>(bytes));
    if (kind == of_imu) taker.imu(stream, values_in<events::ImuSample>(bytes));
    if (kind == of_triggers) taker.triggers(stream, values_in<events::Trigger>(bytes));
  });
}

}  // namespace tactile::conversion
