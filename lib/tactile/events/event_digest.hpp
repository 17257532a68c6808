#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "tactile/events/event.hpp"

namespace tactile::events {

/// Recognises the events of a recording in whatever file they are stored: a copy of other compression, with other packets or
/// without other streams has the same digest. 64 bits by multiplications, about 1 ns per event: enough to distinguish the
/// recordings of one laboratory, and no protection against forgery.
class EventDigest {
 public:
  void add(std::span<const Event> events);  ///< the next events, in their order
  std::string text() const;                 ///< 16 hexadecimal digits

 private:
  std::uint64_t state_ = 0, count_ = 0;
};

/// The digest of a recording's event stream. Reads all of its events.
/// @throws Error  if it cannot be read, or has not one event stream
std::string event_digest_of(const std::filesystem::path& recording);

}  // namespace tactile::events
