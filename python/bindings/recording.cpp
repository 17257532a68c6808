#include "recording.hpp"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <optional>
#include <tuple>
#include <utility>

#include "arrays.hpp"
#include "tactile/core/error.hpp"
#include "working_alone.hpp"

namespace tactile::python {
namespace {

using events::PacketRecord;
using events::RecordingReader;

std::int64_t us(CameraTime t) { return t.time_since_epoch().count(); }

std::optional<std::pair<int, int>> size_of(const Recording& recording) {
  if (!recording.stream.size) return std::nullopt;
  return std::pair(recording.stream.size->width, recording.stream.size->height);
}

/// (index, events, first [us], last [us]) of each packet of the event stream that is not empty.
std::vector<std::tuple<std::size_t, std::int64_t, std::int64_t, std::int64_t>> packets_of(const Recording& recording) {
  std::vector<std::tuple<std::size_t, std::int64_t, std::int64_t, std::int64_t>> packets;
  const auto records = recording.reader.packets();
  for (std::size_t i = 0; i < records.size(); ++i) {
    const PacketRecord& record = records[i];
    if (record.stream_id == recording.stream.id && record.elements > 0)
      packets.emplace_back(i, record.elements, us(record.first), us(record.last));
  }
  return packets;
}

EventBytes take_events(Recording& recording, std::size_t packet) {
  events::OwnedEvents taken;
  {
    const WorkingAlone alone(recording.mutex);
    taken = recording.reader.take_events(recording.reader.packets()[packet]);
  }
  auto* first = reinterpret_cast<std::uint8_t*>(taken.events.data());
  const std::size_t count = taken.events.size();
  return array_of(std::move(taken), first, {count, sizeof(events::Event)});
}

/// Calls `use(reader, packet)` for every packet of a type, of the camera of the event stream if several have the type.
template <class Use>
void for_packets(Recording& recording, events::StreamType type, const Use& use) {
  const WorkingAlone alone(recording.mutex);
  for (const PacketRecord& packet : recording.reader.packets()) {
    const events::Stream& stream = recording.reader.stream(packet.stream_id);
    if (stream.type == type && stream.source == recording.stream.source) use(recording.reader, packet);
  }
}

nb::tuple imu_of(Recording& recording) {
  std::vector<std::int64_t> times;
  std::vector<float> values;
  for_packets(recording, events::StreamType::imu, [&](RecordingReader& reader, const PacketRecord& packet) {
    for (const events::ImuSample& sample : reader.read_imu(packet)) {
      times.push_back(us(sample.t));
      values.push_back(sample.temperature_c);
      for (const auto& vector : {sample.acceleration_g, sample.angular_rate_dps, sample.magnetic_field_ut})
        values.insert(values.end(), vector, vector + 3);
    }
  });
  const std::size_t count = times.size();
  return nb::make_tuple(array_of(std::move(times)), array_of(std::move(values), {count, 10}));
}

nb::tuple triggers_of(Recording& recording) {
  std::vector<std::int64_t> times;
  std::vector<std::int8_t> types;
  for_packets(recording, events::StreamType::triggers, [&](RecordingReader& reader, const PacketRecord& packet) {
    for (const events::Trigger& trigger : reader.read_triggers(packet)) {
      times.push_back(us(trigger.t));
      types.push_back(trigger.type);
    }
  });
  return nb::make_tuple(array_of(std::move(times)), array_of(std::move(types)));
}

std::vector<std::size_t> frame_packets_of(Recording& recording) {
  std::vector<std::size_t> packets;
  const auto records = recording.reader.packets();
  for (std::size_t i = 0; i < records.size(); ++i) {
    const events::Stream& stream = recording.reader.stream(records[i].stream_id);
    if (stream.type == events::StreamType::frames && stream.source == recording.stream.source) packets.push_back(i);
  }
  return packets;
}

/// (time [us], pixels) of a frame of 8 bits per channel; nothing if it cannot be decoded.
nb::object frame_of(Recording& recording, std::size_t packet) {
  std::optional<events::Frame> frame;
  {
    const WorkingAlone alone(recording.mutex);
    frame = recording.reader.read_frame(recording.reader.packets()[packet]);
  }
  if (!frame) return nb::none();
  if (frame->format % 8 != 0)
    throw Error(recording.reader.file().string() + ": a frame has pixels of more than 8 bits per channel; expected 8 bits");
  const auto channels = static_cast<std::size_t>(frame->format) / 8 + 1;
  const std::int64_t t = us(frame->t);
  const auto width = static_cast<std::size_t>(frame->width), height = static_cast<std::size_t>(frame->height);
  return nb::make_tuple(t, array_of(std::move(frame->pixels), {height, width, channels}));
}

nb::dict problems_of(Recording& recording) {
  events::RecordingProblems problems;
  {
    const WorkingAlone alone(recording.mutex);
    problems = recording.reader.problems();
  }
  nb::dict dict;
  if (!problems.table.empty()) dict["table"] = problems.table;
  const auto add = [&](const char* name, std::uint64_t count) {
    if (count > 0) dict[name] = count;
  };
  add("truncated_bytes", problems.truncated_bytes);
  add("skipped_bytes", problems.skipped_bytes);
  add("resized_packets", problems.resized_packets);
  add("empty_packets", problems.empty_packets);
  add("undeclared_packets", problems.undeclared_packets);
  add("mismatched_packets", problems.mismatched_packets);
  add("broken_packets", problems.broken_packets);
  add("out_of_range_events", problems.out_of_range_events);
  add("unwrapped_packets", problems.unwrapped_packets);
  add("missing_packets", problems.missing_packets);
  add("missing_elements", problems.missing_elements);
  return dict;
}

}  // namespace

void bind_recording(nb::module_& module) {
  nb::class_<Recording>(module, "Recording")
      .def(nb::init<const std::string&, const std::string&>(), nb::arg("path"), nb::arg("stream"),
           nb::call_guard<OtherThreadsRun>())
      .def_prop_ro("size", &size_of)
      .def_prop_ro("source", [](const Recording& recording) { return recording.stream.source; })
      .def_prop_ro("problems", &problems_of)
      .def("packets", &packets_of)
      .def("take_events", &take_events, nb::arg("packet"))
      .def("imu", &imu_of)
      .def("triggers", &triggers_of)
      .def("frame_packets", &frame_packets_of)
      .def("frame", &frame_of, nb::arg("packet"));
}

}  // namespace tactile::python
