#include "tactile/events/packet_contents.hpp"

#include <flatbuffers/flatbuffers.h>

#include <array>
#include <cstring>
#include <limits>
#include <string_view>

#include "event_packet_generated.h"
#include "file_data_table_generated.h"
#include "frame_generated.h"
#include "imu_packet_generated.h"
#include "trigger_packet_generated.h"

namespace tactile::events {
namespace {

static_assert(sizeof(aedat4::EventStruct) == sizeof(Event) && alignof(aedat4::EventStruct) == alignof(Event));

constexpr std::size_t prefix_size = sizeof(std::uint32_t);
constexpr std::size_t identifier_end = 12;  ///< prefix, offset of the root, identifier

/// The size that the contents claim, prefix included; 0 if it is impossible.
std::size_t claimed_size(PacketBuffer& packet, std::size_t size) {
  if (size < identifier_end || size >= std::numeric_limits<std::int32_t>::max() - prefix_size) return 0;
  std::uint32_t prefix = 0;
  std::memcpy(&prefix, packet.data(), sizeof prefix);
  const std::size_t claimed = prefix + prefix_size;
  return claimed < identifier_end || claimed > size ? 0 : claimed;
}

/// Checks the contents and returns their root. Writers align 8-byte members relative to the prefix, or to the byte after it. The
/// second kind is moved by 4 bytes.
template <class Root>
Contents verify(PacketBuffer& packet, std::size_t size, const char* identifier, std::size_t tables, const Root*& root) {
  const std::size_t claimed = claimed_size(packet, size);
  if (claimed == 0) return Contents::broken;
  if (std::memcmp(packet.data() + identifier_end - 4, identifier, 4) != 0) return Contents::mismatched;
  const auto max_tables = static_cast<flatbuffers::uoffset_t>(tables);

  const auto* from_prefix = reinterpret_cast<const std::uint8_t*>(packet.data());
  if (flatbuffers::Verifier(from_prefix, claimed, 64, max_tables, true).VerifySizePrefixedBuffer<Root>(identifier)) {
    root = flatbuffers::GetSizePrefixedRoot<Root>(from_prefix);
    return Contents::whole;
  }
  packet.grow(claimed + prefix_size, claimed);
  std::memmove(packet.data() + prefix_size, packet.data(), claimed);
  const auto* after_prefix = reinterpret_cast<const std::uint8_t*>(packet.data()) + 2 * prefix_size;
  if (!flatbuffers::Verifier(after_prefix, claimed - prefix_size, 64, max_tables, true).VerifyBuffer<Root>(identifier)) {
    return Contents::broken;
  }
  root = flatbuffers::GetRoot<Root>(after_prefix);
  return Contents::whole;
}

/// A table and its offset take at least 8 bytes, so a sound packet has at most this many.
std::size_t most_tables(std::size_t size) { return size / 8 + 2; }

std::size_t copy_to(const flatbuffers::FlatBufferBuilder& builder, PacketBuffer& packet, std::size_t reserved) {
  packet.grow(reserved + builder.GetSize(), 0);
  std::memcpy(packet.data() + reserved, builder.GetBufferPointer(), builder.GetSize());
  return builder.GetSize();
}

}  // namespace

Contents decode_events(PacketBuffer& packet, std::size_t size, std::span<Event>& events) {
  constexpr std::string_view lossy = "LBEV";  // where other contents have the size prefix, or their identifier
  for (const std::size_t at : {std::size_t{0}, identifier_end - lossy.size()}) {
    if (size >= at + lossy.size() && std::memcmp(packet.data() + at, lossy.data(), lossy.size()) == 0) return Contents::lossy;
  }
  const aedat4::EventPacket* root = nullptr;
  const Contents contents = verify(packet, size, aedat4::EventPacketIdentifier(), 1, root);
  if (contents != Contents::whole) return contents;
  events = {};
  if (root->elements() == nullptr || root->elements()->size() == 0) return contents;
  const std::size_t count = root->elements()->size();
  std::byte* data = packet.data() + (root->elements()->Data() - reinterpret_cast<const std::uint8_t*>(packet.data()));
  if (const std::size_t past = static_cast<std::size_t>(data - packet.data()) % alignof(Event); past != 0) {
    std::memmove(data - past, data, count * sizeof(Event));
    data -= past;
  }
  events = {reinterpret_cast<Event*>(data), count};
  return contents;
}

Contents decode_imu(PacketBuffer& packet, std::size_t size, std::vector<ImuSample>& samples) {
  const aedat4::ImuPacket* root = nullptr;
  const Contents contents = verify(packet, size, aedat4::ImuPacketIdentifier(), most_tables(size), root);
  samples.clear();
  if (contents != Contents::whole || root->elements() == nullptr) return contents;
  samples.reserve(root->elements()->size());
  for (const aedat4::Imu* imu : *root->elements()) {
    samples.push_back({.t = camera_time(imu->timestamp()),
                       .temperature_c = imu->temperature(),
                       .acceleration_g = {imu->accelerometer_x(), imu->accelerometer_y(), imu->accelerometer_z()},
                       .angular_rate_dps = {imu->gyroscope_x(), imu->gyroscope_y(), imu->gyroscope_z()},
                       .magnetic_field_ut = {imu->magnetometer_x(), imu->magnetometer_y(), imu->magnetometer_z()}});
  }
  return contents;
}

Contents decode_triggers(PacketBuffer& packet, std::size_t size, std::vector<Trigger>& triggers) {
  const aedat4::TriggerPacket* root = nullptr;
  const Contents contents = verify(packet, size, aedat4::TriggerPacketIdentifier(), most_tables(size), root);
  triggers.clear();
  if (contents != Contents::whole || root->elements() == nullptr) return contents;
  triggers.reserve(root->elements()->size());
  for (const aedat4::TriggerTable* trigger : *root->elements()) {
    triggers.push_back({.t = camera_time(trigger->timestamp()), .type = trigger->type()});
  }
  return contents;
}

Contents decode_frame(PacketBuffer& packet, std::size_t size, Frame& frame) {
  const aedat4::FrameTable* root = nullptr;
  const Contents contents = verify(packet, size, aedat4::FrameTableIdentifier(), 1, root);
  if (contents != Contents::whole) return contents;
  const std::size_t pixels = root->pixels() == nullptr ? 0 : root->pixels()->size();
  const std::size_t pixel = bytes_per_pixel(root->format());
  if (pixel == 0 || root->size_x() < 0 || root->size_y() < 0) return Contents::broken;
  if (pixels != pixel * static_cast<std::size_t>(root->size_x()) * static_cast<std::size_t>(root->size_y()))
    return Contents::broken;
  frame.t = camera_time(root->timestamp());
  frame.frame_start = camera_time(root->frame_start());
  frame.frame_end = camera_time(root->frame_end());
  frame.exposure_start = camera_time(root->exposure_start());
  frame.exposure_end = camera_time(root->exposure_end());
  frame.format = root->format();
  frame.width = root->size_x();
  frame.height = root->size_y();
  frame.position_x = root->position_x();
  frame.position_y = root->position_y();
  frame.pixels.clear();
  if (pixels > 0) frame.pixels.assign(root->pixels()->Data(), root->pixels()->Data() + pixels);
  return contents;
}

Contents decode_table(PacketBuffer& table, std::size_t size, std::vector<PacketRecord>& records) {
  const aedat4::FileDataTable* root = nullptr;
  const Contents contents = verify(table, size, aedat4::FileDataTableIdentifier(), most_tables(size), root);
  records.clear();
  if (contents != Contents::whole || root->table() == nullptr) return contents;
  records.reserve(root->table()->size());
  for (const aedat4::FileDataDefinition* entry : *root->table()) {
    const aedat4::PacketHeader* header = entry->packet_info();
    if (header == nullptr || header->size() < 0 || entry->byte_offset() < 0) return Contents::broken;
    records.push_back({.stream_id = header->stream_id(),
                       .payload_offset = static_cast<std::uint64_t>(entry->byte_offset()),
                       .payload_size = static_cast<std::uint32_t>(header->size()),
                       .elements = entry->num_elements(),
                       .first = camera_time(entry->timestamp_start()),
                       .last = camera_time(entry->timestamp_end())});
  }
  return contents;
}

void write_event_packet_head(std::byte* head, std::size_t count) {
  const auto put = [head](std::size_t at, auto value) { std::memcpy(head + at, &value, sizeof value); };
  put(0, static_cast<std::uint32_t>(event_packet_head - prefix_size + count * sizeof(Event)));
  put(4, std::uint32_t{16});  // the root table is at 4 + 16
  std::memcpy(head + 8, aedat4::EventPacketIdentifier(), 4);
  put(12, std::uint16_t{0});
  put(14, std::uint16_t{6});  // its vtable: its size, the table's size, the place of the only field
  put(16, std::uint16_t{8});
  put(18, std::uint16_t{4});
  put(20, std::int32_t{6});  // the table: distances back to its vtable and forward to its vector
  put(24, std::uint32_t{4});
  put(28, static_cast<std::uint32_t>(count));
}

std::size_t encode_imu(std::span<const ImuSample> samples, PacketBuffer& packet, std::size_t reserved) {
  flatbuffers::FlatBufferBuilder builder;
  std::vector<flatbuffers::Offset<aedat4::Imu>> elements;
  elements.reserve(samples.size());
  for (const ImuSample& s : samples) {
    elements.push_back(aedat4::CreateImu(builder, us_of(s.t), s.temperature_c, s.acceleration_g[0], s.acceleration_g[1],
                                         s.acceleration_g[2], s.angular_rate_dps[0], s.angular_rate_dps[1], s.angular_rate_dps[2],
                                         s.magnetic_field_ut[0], s.magnetic_field_ut[1], s.magnetic_field_ut[2]));
  }
  const auto vector = builder.CreateVector(elements);
  aedat4::FinishSizePrefixedImuPacketBuffer(builder, aedat4::CreateImuPacket(builder, vector));
  return copy_to(builder, packet, reserved);
}

std::size_t encode_triggers(std::span<const Trigger> triggers, PacketBuffer& packet, std::size_t reserved) {
  flatbuffers::FlatBufferBuilder builder;
  std::vector<flatbuffers::Offset<aedat4::TriggerTable>> elements;
  elements.reserve(triggers.size());
  for (const Trigger& trigger : triggers) {
    elements.push_back(aedat4::CreateTriggerTable(builder, us_of(trigger.t), trigger.type));
  }
  const auto vector = builder.CreateVector(elements);
  aedat4::FinishSizePrefixedTriggerPacketBuffer(builder, aedat4::CreateTriggerPacket(builder, vector));
  return copy_to(builder, packet, reserved);
}

std::size_t encode_frame(const Frame& frame, PacketBuffer& packet, std::size_t reserved) {
  flatbuffers::FlatBufferBuilder builder(frame.pixels.size() + 256);
  const auto pixels = builder.CreateVector(frame.pixels.data(), frame.pixels.size());
  const std::int64_t exposure = saturating_subtract(us_of(frame.exposure_end), us_of(frame.exposure_start));
  aedat4::FinishSizePrefixedFrameTableBuffer(
      builder, aedat4::CreateFrameTable(builder, us_of(frame.t), us_of(frame.frame_start), us_of(frame.frame_end),
                                        us_of(frame.exposure_start), us_of(frame.exposure_end), frame.format, frame.width,
                                        frame.height, frame.position_x, frame.position_y, pixels, exposure));
  return copy_to(builder, packet, reserved);
}

std::size_t bytes_per_pixel(std::int8_t format) {
  constexpr std::array<std::size_t, 8> depths{1, 1, 2, 2, 4, 4, 8, 2};  // in OpenCV's order, u8 to f16
  if (format < 0) return 0;
  const std::size_t bits = static_cast<unsigned char>(format);
  return depths[bits % 8] * (bits / 8 + 1);
}

}  // namespace tactile::events
