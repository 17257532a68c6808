#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <vector>

#include "tactile/capture/camera_source.hpp"

namespace tactile::test {

/// What a source gave, whole.
struct Received {
  std::map<std::int32_t, capture::CameraPacket> streams;  ///< each one's elements, one after the other
  std::vector<std::int32_t> order;                        ///< of the packets' streams
  std::vector<CameraTime> begins;                         ///< of the packets
  std::chrono::microseconds longest_packet{};             ///< from its first element to its last
};

template <class T>
void append(const std::vector<T>& from, std::vector<T>& to, Received& all) {
  if (from.empty()) return;
  all.begins.push_back(from.front().t);
  all.longest_packet = std::max(all.longest_packet, from.back().t - from.front().t);
  to.insert(to.end(), from.begin(), from.end());
}

inline void add(const capture::CameraPacket& packet, Received& all) {
  all.order.push_back(packet.stream_id);
  capture::CameraPacket& stream = all.streams[packet.stream_id];
  append(packet.events, stream.events, all);
  append(packet.imu, stream.imu, all);
  append(packet.triggers, stream.triggers, all);
}

/// Receives until the source ends; a source that gives nothing for a minute has failed.
inline Received receive_all(capture::CameraSource& source) {
  Received all;
  capture::CameraPacket packet;
  auto last = std::chrono::steady_clock::now();
  for (;;) {
    const capture::CameraSource::Received received = source.receive(packet, std::chrono::milliseconds(50));
    if (received == capture::CameraSource::Received::ended) return all;
    if (received == capture::CameraSource::Received::packet) {
      add(packet, all);
      last = std::chrono::steady_clock::now();
    } else if (std::chrono::steady_clock::now() - last > std::chrono::minutes(1)) {
      ADD_FAILURE() << "nothing came for a minute";
      return all;
    }
  }
}

}  // namespace tactile::test
