#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/events/other_streams.hpp"
#include "tactile/events/packet_compression.hpp"
#include "tactile/events/stream.hpp"
#include "tactile/transport/dv/dv_stream_client.hpp"

namespace tactile::transport {

/// Decodes the bytes of a DV stream: a header, then packets. `room` returns where the next bytes belong, so that they are
/// received where they are decoded. An incomplete packet waits for its remaining bytes.
class DvStreamParser {
 public:
  /// @param where  name of the stream in errors
  explicit DvStreamParser(std::string where) : where_(std::move(where)) {}

  /// Where the next bytes belong, never empty. The last packet is no longer valid.
  /// @throws Error  if the next packet's size is impossible
  std::span<std::byte> room();

  /// Decodes the `count` bytes at the front of `room`; true if they complete a sound packet.
  /// @throws Error  if they are not the header of a DV stream
  bool received(std::size_t count);

  /// Ends the stream. @throws Error  if that is inside the header or a packet
  void end() const;

  bool has_header() const { return part_ == Part::packet_header || part_ == Part::payload; }
  bool is_between_packets() const { return part_ == Part::packet_header && have_ == 0; }
  const events::Stream& stream() const { return stream_; }  ///< once the header is complete
  events::Compression compression() const { return compression_; }

  // Contents of the last packet, valid until the next `room`.
  std::span<events::Event> events() { return events_; }
  std::span<const events::ImuSample> imu() const { return imu_; }
  std::span<const events::Trigger> triggers() const { return triggers_; }
  const std::optional<events::Frame>& frame() const { return frame_; }

  const DvStreamProblems& problems() const { return problems_; }

 private:
  static constexpr std::size_t packet_header_size = 8;
  enum class Part : std::uint8_t { start, header, packet_header, payload };

  void check_start() const;
  void read_stream_header();
  void begin_packet();
  bool take_packet();
  events::PacketBuffer& incoming() {
    return part_ == Part::header || compression_ == events::Compression::none ? content_ : stored_;
  }

  std::string where_;
  Part part_ = Part::start;
  std::size_t have_ = 0;               ///< [B] of this part
  std::array<std::byte, 12> start_{};  ///< size prefix, offset and identifier of the header
  std::array<std::byte, packet_header_size> packet_header_{};
  std::size_t size_ = 0;  ///< of the header with its prefix, or of the packet's payload [B]
  std::int32_t packet_id_ = 0;
  events::Stream stream_;
  events::Compression compression_ = events::Compression::none;
  events::PacketBuffer stored_, content_;
  events::PacketDecompressor decompressor_;
  std::span<events::Event> events_;
  std::vector<events::ImuSample> imu_;
  std::vector<events::Trigger> triggers_;
  std::optional<events::Frame> frame_;
  DvStreamProblems problems_;
};

}  // namespace tactile::transport
