#include <fmt/core.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "tactile/conversion/hdf5_recording.hpp"
#include "tactile/conversion/hdf5_recording_layout.hpp"
#include "tactile/core/error.hpp"
#include "tactile/hdf5/hdf5_objects.hpp"

namespace tactile::conversion {
namespace fs = std::filesystem;
namespace h5 = hdf5;
using hdf5_layout::chunk_rows;
using hdf5_layout::groups;

namespace {

constexpr std::int64_t layout_version = 1;

/// Empty if HDF5 recordings have no such streams.
std::string_view group_of(events::StreamType type) {
  const auto* found = std::find_if(std::begin(groups), std::end(groups), [type](const auto& g) { return g.first == type; });
  return found == std::end(groups) ? std::string_view{} : found->second;
}

/// A column that is written. Values are gathered until a chunk is full.
template <class T>
struct ColumnOut {
  h5::Id table;
  std::string where;
  hsize_t width = 1;  ///< values in a row
  std::vector<T> waiting;

  void create(hid_t group, const std::string& name, hsize_t row_width, const std::string& group_name) {
    where = group_name + "/" + name;
    width = row_width;
    const std::vector<hsize_t> row = row_width == 1 ? std::vector<hsize_t>{} : std::vector<hsize_t>{row_width};
    table = h5::create_table(group, name, h5::file_type<T>(), row, chunk_rows, where);
  }
  void put() {
    if (!waiting.empty()) h5::append_rows(table, h5::memory_type<T>(), waiting.data(), waiting.size() / width, where);
    waiting.clear();
  }
  void close() {
    put();
    table.close(where);
  }
};

struct StreamOut {
  events::Stream stream;
  h5::Id group;
  std::string where;
  ColumnOut<std::int64_t> t;
  ColumnOut<std::uint16_t> x, y;
  ColumnOut<std::uint8_t> on;
  ColumnOut<float> temperature, acceleration, angular_rate, magnetic_field;
  ColumnOut<std::int8_t> type;
  CameraTime previous = CameraTime::min();

  template <class Use>
  void for_columns(const Use& use) {
    use(t);
    if (stream.type == events::StreamType::events) use(x), use(y), use(on);
    if (stream.type == events::StreamType::imu) use(temperature), use(acceleration), use(angular_rate), use(magnetic_field);
    if (stream.type == events::StreamType::triggers) use(type);
  }
};

}  // namespace

struct Hdf5RecordingWriter::State {
  fs::path path;
  h5::Id file;
  std::vector<StreamOut> streams;

  ~State() {
    const h5::Session session;
    streams.clear();
    file = h5::Id();
  }

  void open(std::span<const events::Stream> declared) {
    const std::string name = path.string();
    file = h5::create_file(path, h5::Structure::plain);
    h5::write_attribute(file, "recording_format", layout_version, name);
    const auto events = std::find_if(declared.begin(), declared.end(),
                                     [](const events::Stream& s) { return s.type == events::StreamType::events; });
    if (events != declared.end()) {
      // These attributes apply to every stream without a size of its own, so a stream without a size rules them out.
      const bool all_have_size = std::all_of(declared.begin(), declared.end(), [](const events::Stream& s) {
        return s.type != events::StreamType::events || s.size;
      });
      if (all_have_size) {
        h5::write_attribute(file, "sensor_width", std::int64_t{events->size->width}, name);
        h5::write_attribute(file, "sensor_height", std::int64_t{events->size->height}, name);
      }
      h5::write_attribute(file, "source", events->source, name);
    }
    streams.reserve(declared.size());
    for (const events::Stream& stream : declared) add(stream);
  }

  void add(const events::Stream& stream) {
    std::string name(group_of(stream.type));
    if (name.empty()) {
      throw Error(fmt::format("{}: stream {} holds {}; expected events, imu or triggers", path.string(), stream.id,
                              name_of(stream.type)));
    }
    if (h5::has_member(file, name)) name += "_" + std::to_string(stream.id);
    StreamOut& out = streams.emplace_back();
    out.stream = stream;
    out.where = path.string() + ": /" + name;
    out.group = h5::create_group(file, name, path.string());
    h5::write_attribute(out.group, "stream_id", std::int64_t{stream.id}, out.where);
    h5::write_attribute(out.group, "name", stream.name, out.where);
    h5::write_attribute(out.group, "source", stream.source, out.where);
    if (stream.size) {
      h5::write_attribute(out.group, "width", std::int64_t{stream.size->width}, out.where);
      h5::write_attribute(out.group, "height", std::int64_t{stream.size->height}, out.where);
    }
    nlohmann::ordered_json info = nlohmann::ordered_json::object();
    for (const auto& [key, value] : stream.info) info[key] = value;
    h5::write_attribute(out.group, "info", info.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace), out.where);

    out.t.create(out.group, "t_us", 1, out.where);
    if (stream.type == events::StreamType::events) {
      out.x.create(out.group, "x", 1, out.where);
      out.y.create(out.group, "y", 1, out.where);
      out.on.create(out.group, "on", 1, out.where);
    } else if (stream.type == events::StreamType::imu) {
      out.temperature.create(out.group, "temperature_c", 1, out.where);
      out.acceleration.create(out.group, "acceleration_g", 3, out.where);
      out.angular_rate.create(out.group, "angular_rate_dps", 3, out.where);
      out.magnetic_field.create(out.group, "magnetic_field_ut", 3, out.where);
    } else {
      out.type.create(out.group, "type", 1, out.where);
    }
  }

  /// Passes each element to `append`, which adds it to every column except `t_us`.
  template <class Element, class Append>
  void write(std::int32_t id, std::span<const Element> elements, const Append& append) {
    const h5::Session session;
    const auto out = std::find_if(streams.begin(), streams.end(), [id](const StreamOut& s) { return s.stream.id == id; });
    if (out == streams.end()) throw Error(fmt::format("{}: has no stream {}; expected one of its own", path.string(), id));
    for (const Element& element : elements) {
      if (element.t < out->previous) {
        throw Error(fmt::format("{}: goes back in time, from {} to {} us; expected times that never fall", out->where,
                                us_of(out->previous), us_of(element.t)));
      }
      out->previous = element.t;
      out->t.waiting.push_back(us_of(element.t));
      append(*out, element);
      if (out->t.waiting.size() == chunk_rows) out->for_columns([](auto& column) { column.put(); });
    }
  }
};

Hdf5RecordingWriter::Hdf5RecordingWriter(const fs::path& file, std::span<const events::Stream> streams)
    : state_(std::make_unique<State>()) {
  const h5::Session session;
  state_->path = file;
  state_->open(streams);
}
Hdf5RecordingWriter::~Hdf5RecordingWriter() = default;
Hdf5RecordingWriter::Hdf5RecordingWriter(Hdf5RecordingWriter&&) noexcept = default;
Hdf5RecordingWriter& Hdf5RecordingWriter::operator=(Hdf5RecordingWriter&&) noexcept = default;

void Hdf5RecordingWriter::write_events(std::int32_t stream_id, std::span<const events::Event> events) {
  state_->write(stream_id, events, [](StreamOut& out, const events::Event& event) {
    out.x.waiting.push_back(static_cast<std::uint16_t>(event.x));
    out.y.waiting.push_back(static_cast<std::uint16_t>(event.y));
    out.on.waiting.push_back(event.on);
  });
}

void Hdf5RecordingWriter::write_imu(std::int32_t stream_id, std::span<const events::ImuSample> samples) {
  state_->write(stream_id, samples, [](StreamOut& out, const events::ImuSample& sample) {
    const auto append = [](ColumnOut<float>& column, const auto& xyz) {
      column.waiting.insert(column.waiting.end(), std::begin(xyz), std::end(xyz));
    };
    out.temperature.waiting.push_back(sample.temperature_c);
    append(out.acceleration, sample.acceleration_g);
    append(out.angular_rate, sample.angular_rate_dps);
    append(out.magnetic_field, sample.magnetic_field_ut);
  });
}

void Hdf5RecordingWriter::write_triggers(std::int32_t stream_id, std::span<const events::Trigger> triggers) {
  state_->write(stream_id, triggers,
                [](StreamOut& out, const events::Trigger& trigger) { out.type.waiting.push_back(trigger.type); });
}

void Hdf5RecordingWriter::close() {
  const h5::Session session;
  for (StreamOut& out : state_->streams) {
    out.for_columns([](auto& column) { column.close(); });
    out.group.close(out.where);
  }
  state_->file.close(state_->path.string());
}

}  // namespace tactile::conversion
