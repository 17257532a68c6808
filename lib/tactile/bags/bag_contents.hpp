#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tactile/bags/bag.hpp"
#include "tactile/core/progress.hpp"
#include "tactile/events/event.hpp"

namespace tactile::bags {

/// What a topic of a bag contains. Times of events are those of the camera, or of its driver.
struct TopicContents {
  std::string name, type;
  std::uint64_t messages = 0;
  HostTime first_received{}, last_received{};
  std::uint64_t broken_messages = 0;  ///< of events, not decodable

  // Of a topic with events:
  bool has_events = false;
  std::string encoding;  ///< of EventPackets: the first
  std::optional<events::SensorSize> size;
  std::uint64_t events = 0, on_events = 0, triggers = 0;
  std::uint64_t outside = 0;       ///< events outside the sensor
  std::uint64_t unplaced = 0;      ///< events before the first time and row of `evt3`
  std::uint64_t lost_packets = 0;  ///< gaps in the sequence numbers
  CameraTime first{}, last{};      ///< earliest and latest event, if there is one
};

struct BagContents {
  std::string format;  ///< "ROS 2 bag (MCAP)"
  std::uint64_t files = 0, bytes = 0;
  std::vector<TopicContents> topics;  ///< by name
  BagProblems problems;
};

/// Reads a bag completely and decodes its events. Memory follows the chunk and the message.
/// @throws Error  if it cannot be read, or has more than 4096 topics
BagContents read_bag_contents(const std::filesystem::path& place, const ProgressCallback& progress = {});

}  // namespace tactile::bags
