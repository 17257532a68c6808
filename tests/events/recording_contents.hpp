#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/sha256.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/recording_reader.hpp"

namespace tactile::test {

/// SHA-256 over events in their order, each as 13 bytes: int64 t, int16 x, int16 y, uint8 polarity, little-endian.
class EventDigest {
 public:
  void add(std::span<const events::Event> events) {
    packed_.resize(events.size() * 13);
    std::byte* at = packed_.data();
    for (const events::Event& e : events) {
      const std::int64_t t = us_of(e.t);
      std::memcpy(at, &t, 8);
      std::memcpy(at + 8, &e.x, 2);
      std::memcpy(at + 10, &e.y, 2);
      std::memcpy(at + 12, &e.on, 1);
      at += 13;
    }
    digest_.add(packed_);
  }
  std::string hex() { return digest_.hex(); }

 private:
  Sha256 digest_;
  std::vector<std::byte> packed_;
};

/// Everything that a recording holds, all event streams one after the other packet by packet.
struct RecordingContents {
  std::vector<events::Event> events;
  std::vector<events::ImuSample> imu;
  std::vector<events::Trigger> triggers;
  std::vector<events::Frame> frames;
  std::int64_t event_packets = 0;

  std::string event_digest() const {
    EventDigest digest;
    digest.add(events);
    return digest.hex();
  }
  std::string frame_digest() const {
    Sha256 digest;
    for (const events::Frame& frame : frames) digest.add(std::as_bytes(std::span(frame.pixels)));
    return digest.hex();
  }
};

inline RecordingContents contents_of(events::RecordingReader& recording) {
  RecordingContents all;
  for (const events::PacketRecord& packet : recording.packets()) {
    switch (recording.stream(packet.stream_id).type) {
      case events::StreamType::events: {
        const auto events = recording.read_events(packet);
        all.events.insert(all.events.end(), events.begin(), events.end());
        ++all.event_packets;
        break;
      }
      case events::StreamType::imu:
        for (const events::ImuSample& sample : recording.read_imu(packet)) all.imu.push_back(sample);
        break;
      case events::StreamType::triggers:
        for (const events::Trigger& trigger : recording.read_triggers(packet)) all.triggers.push_back(trigger);
        break;
      case events::StreamType::frames:
        if (auto frame = recording.read_frame(packet)) all.frames.push_back(std::move(*frame));
        break;
      case events::StreamType::other:
        break;
    }
  }
  return all;
}

inline RecordingContents contents_of(const std::filesystem::path& file) {
  events::RecordingReader recording(file);
  return contents_of(recording);
}

inline bool same(const events::ImuSample& a, const events::ImuSample& b) {
  const auto equal = [](const auto& one, const auto& other) {
    return std::equal(std::begin(one), std::end(one), std::begin(other));
  };
  return a.t == b.t && a.temperature_c == b.temperature_c && equal(a.acceleration_g, b.acceleration_g) &&
         equal(a.angular_rate_dps, b.angular_rate_dps) && equal(a.magnetic_field_ut, b.magnetic_field_ut);
}
inline bool same(const events::Trigger& a, const events::Trigger& b) { return a.t == b.t && a.type == b.type; }
inline bool same(const events::Frame& a, const events::Frame& b) {
  return a.t == b.t && a.frame_start == b.frame_start && a.frame_end == b.frame_end && a.exposure_start == b.exposure_start &&
         a.exposure_end == b.exposure_end && a.format == b.format && a.width == b.width && a.height == b.height &&
         a.position_x == b.position_x && a.position_y == b.position_y && a.pixels == b.pixels;
}
template <class T>
bool same(const std::vector<T>& a, const std::vector<T>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const T& one, const T& other) { return same(one, other); });
}
inline bool same(const RecordingContents& a, const RecordingContents& b) {
  return a.events == b.events && same(a.imu, b.imu) && same(a.triggers, b.triggers) && same(a.frames, b.frames);
}

/// A packet as the file has it, with its header.
inline std::string stored_bytes(const std::filesystem::path& file, const events::PacketRecord& packet) {
  return read_text(file).substr(packet.payload_offset - 8, packet.payload_size + 8);
}

}  // namespace tactile::test
