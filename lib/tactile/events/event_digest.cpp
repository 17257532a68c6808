#include "tactile/events/event_digest.hpp"

#include <fmt/core.h>

#include "tactile/events/recording_reader.hpp"

namespace tactile::events {
namespace {

/// A bijection that changes about half of the bits for each changed one.
/// Source: Steele, Lea, Flood: Fast splittable pseudorandom number generators, OOPSLA 2014 (SplitMix64).
std::uint64_t mixed(std::uint64_t x) {
  x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27U)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31U);
}

}  // namespace

void EventDigest::add(std::span<const Event> events) {
  for (const Event& event : events) {
    const std::uint64_t place = std::uint64_t{static_cast<std::uint16_t>(event.x)} << 32U |
                                std::uint64_t{static_cast<std::uint16_t>(event.y)} << 16U | event.on;
    state_ = mixed(state_ ^ static_cast<std::uint64_t>(us_of(event.t))) + place;
  }
  count_ += events.size();
}

std::string EventDigest::text() const { return fmt::format("{:016x}", mixed(state_ ^ mixed(count_))); }

std::string event_digest_of(const std::filesystem::path& recording) {
  RecordingReader reader(recording);
  EventDigest digest;
  for_all_events(reader, event_stream(reader).id, [&](std::span<const Event> events) { digest.add(events); });
  return digest.text();
}

}  // namespace tactile::events
