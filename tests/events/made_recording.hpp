#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/whole_file.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile::test {

inline events::Event event_at(std::int64_t t_us, int x = 0, int y = 0, int on = 1) {
  events::Event event{.t = camera_time(t_us), .x = static_cast<std::int16_t>(x), .y = static_cast<std::int16_t>(y)};
  event.on = static_cast<std::uint8_t>(on);
  return event;
}

/// `count` events one every `step_us` from `begin_us` on, wandering over the sensor.
inline std::vector<events::Event> steady_events(std::size_t count, std::int64_t begin_us, std::int64_t step_us,
                                                events::SensorSize size) {
  std::vector<events::Event> events;
  for (std::size_t i = 0; i < count; ++i) {
    const int k = static_cast<int>(i);
    events.push_back(event_at(begin_us + step_us * static_cast<std::int64_t>(i), 7 * k % size.width, 11 * k % size.height,
                              k % 3 == 0 ? 1 : 0));
  }
  return events;
}

inline events::Stream stream_of(std::int32_t id, events::StreamType type, const std::string& identifier,
                                const std::string& source = "DVXplorer_DXM00001") {
  events::Stream stream;
  stream.id = id;
  stream.type = type;
  stream.type_identifier = identifier;
  stream.source = source;
  stream.name = name_of(type);
  stream.info = {{"tsOffset", "1605507430438338"}};
  return stream;
}

/// Uncompressed, so that a test can damage it byte by byte: events of 16 bytes each, after the 32 that every such packet begins
/// with.
inline void write_plain_recording(const std::filesystem::path& file, std::span<const events::Event> events,
                                  events::SensorSize size) {
  events::RecordingWriter writer(file, {events::event_stream_declaration(size, "DVXplorer_DXM00001")},
                                 {.compression = events::Compression::none});
  writer.write_events(0, events);
  writer.close();
}

/// Two cameras, A and B, each with events (streams 0 and 4) and an inertial sensor (2 and 6).
inline void write_two_cameras(const std::filesystem::path& file) {
  events::Stream second = stream_of(4, events::StreamType::events, "EVTS", "B");
  second.size = events::SensorSize{32, 24};
  events::RecordingWriter writer(
      file, {events::event_stream_declaration({64, 48}, "A"), stream_of(2, events::StreamType::imu, "IMUS", "A"), second,
             stream_of(6, events::StreamType::imu, "IMUS", "B")});
  writer.write_events(0, steady_events(30, 0, 100, {64, 48}));
  writer.write_events(4, steady_events(20, 0, 100, {32, 24}));
  events::ImuSample sample;
  writer.write_imu(2, {&sample, 1});
  writer.write_imu(6, {&sample, 1});
  writer.close();
}

inline std::uint64_t event_offset(const events::PacketRecord& packet, std::size_t event_index) {
  return packet.payload_offset + 32 + 16 * event_index;
}

template <class T>
void overwrite(const std::filesystem::path& file, std::uint64_t offset, const T& value) {
  std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
  stream.seekp(static_cast<std::streamoff>(offset));
  stream.write(reinterpret_cast<const char*>(&value), sizeof value);
}

inline std::vector<events::PacketRecord> packets_of(const std::filesystem::path& file) {
  const events::RecordingReader recording(file);
  return {recording.packets().begin(), recording.packets().end()};
}

/// Where the vendor's header layout has the data table's position.
inline constexpr std::uint64_t table_position_offset = 54;

/// The file as after a kill: no table, and no byte after its last whole packet.
inline void cut_off_table(const std::filesystem::path& file) {
  const events::PacketRecord last = packets_of(file).back();
  std::filesystem::resize_file(file, last.payload_offset + last.payload_size);
  overwrite(file, table_position_offset, std::int64_t{-1});
}

}  // namespace tactile::test
