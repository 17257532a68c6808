#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/events/other_streams.hpp"
#include "tactile/events/packet_compression.hpp"
#include "tactile/events/recording_reader.hpp"

namespace tactile::events {

/// The state of a packet's contents.
enum class Contents : std::uint8_t {
  whole,
  mismatched,
  broken,
  lossy  ///< counts of events in bins of time, as jAER 3.6 writes on request. Source: jAER, Aedat4LossyTimeBins.java
};

/// Why a recording with lossy contents is refused.
inline constexpr std::string_view lossy_contents =
    "has jAER's lossy time bins (LBEV), which count events instead of listing them; expected events (EVTS): record again, with "
    "lossy time bins off in jAER";

// Reading: `packet` begins with `size` decompressed bytes, with their size prefix. Everything in them is checked before use.
// Contents at unaligned addresses are moved inside the buffer.

/// The events in place: valid until the buffer changes.
Contents decode_events(PacketBuffer& packet, std::size_t size, std::span<Event>& events);
Contents decode_imu(PacketBuffer& packet, std::size_t size, std::vector<ImuSample>& samples);
Contents decode_triggers(PacketBuffer& packet, std::size_t size, std::vector<Trigger>& triggers);
Contents decode_frame(PacketBuffer& packet, std::size_t size,
                      Frame& frame);  ///< also broken if the number of pixels does not fit its size

/// The data table, with the offsets of the file.
Contents decode_table(PacketBuffer& table, std::size_t size, std::vector<PacketRecord>& records);

// Writing: contents with their size prefix, after `reserved` bytes of `packet`. Each returns their size.

/// The head of an EVTS packet before its events [B].
inline constexpr std::size_t event_packet_head = 32;
/// Writes that head for `count` events, in the layout of FlatBuffers, which the vendor's files have too.
void write_event_packet_head(std::byte* head, std::size_t count);

std::size_t encode_imu(std::span<const ImuSample> samples, PacketBuffer& packet, std::size_t reserved);
std::size_t encode_triggers(std::span<const Trigger> triggers, PacketBuffer& packet, std::size_t reserved);
std::size_t encode_frame(const Frame& frame, PacketBuffer& packet, std::size_t reserved);

/// The bytes per pixel of a format; 0 for an unknown one.
std::size_t bytes_per_pixel(std::int8_t format);

}  // namespace tactile::events
