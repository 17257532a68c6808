#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/events/other_streams.hpp"
#include "tactile/events/packet_compression.hpp"
#include "tactile/events/recording_reader.hpp"

namespace tactile {

/// How a packet's contents turned out.
enum class Contents : std::uint8_t { whole, mismatched, broken };

// Reading: `size` decompressed bytes, the size prefix first, stand at the front of `packet`. Everything in them is checked before
// it is used. Contents are rearranged in the buffer where they lie at addresses that the machine would have to read byte by byte.

/// The events in place: valid as long as the buffer is left alone.
Contents decode_events(PacketBuffer& packet, std::size_t size, std::span<Event>& events);
Contents decode_imu(PacketBuffer& packet, std::size_t size, std::vector<ImuSample>& samples);
Contents decode_triggers(PacketBuffer& packet, std::size_t size, std::vector<Trigger>& triggers);
Contents decode_frame(PacketBuffer& packet, std::size_t size, Frame& frame);  ///< broken also if its pixels do not fill its size

/// The data table, offsets as they stand in the file.
Contents decode_table(PacketBuffer& table, std::size_t size, std::vector<PacketRecord>& records);

// Writing: contents with their size prefix, behind `reserved` bytes of `packet`; each returns their size.

/// What an EVTS packet has in front of its events [B].
inline constexpr std::size_t event_packet_head = 32;
/// Fills in that head for `count` events. The layout is what FlatBuffers makes of such a packet, and the vendor's files have it
/// too.
void write_event_packet_head(std::byte* head, std::size_t count);

std::size_t encode_imu(std::span<const ImuSample> samples, PacketBuffer& packet, std::size_t reserved);
std::size_t encode_triggers(std::span<const Trigger> triggers, PacketBuffer& packet, std::size_t reserved);
std::size_t encode_frame(const Frame& frame, PacketBuffer& packet, std::size_t reserved);

/// Bytes of a pixel of this format; 0 if there is no such format.
std::size_t bytes_per_pixel(std::int8_t format);

}  // namespace tactile
