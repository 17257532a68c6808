#include "tactile/bags/ros_events.hpp"

#include "tactile/bags/bag_file.hpp"

namespace tactile::bags {
namespace {

constexpr std::size_t most_events = std::size_t{8} << 20;  // of a message; drivers send less than a hundredth of it
constexpr std::size_t event_bytes = 13;                    // x, y, seconds, nanoseconds, polarity
constexpr std::size_t libcaer_event_bytes = 8;             // place and polarity, microseconds

void add_event(RosEvents& into, std::int64_t t_us, unsigned x, unsigned y, bool on) {
  if (x >= static_cast<unsigned>(into.size.width) || y >= static_cast<unsigned>(into.size.height)) {
    ++into.outside;
    return;
  }
  events::Event& event = into.events.emplace_back();
  event.t = camera_time(t_us);
  event.x = static_cast<std::int16_t>(x);
  event.y = static_cast<std::int16_t>(y);
  event.on = on ? 1 : 0;
}

/// The camera driver's structs: bit 1 the polarity, 15 bits y, 15 bits x; then the lower 31 bits of the time.
void decode_libcaer(Bytes data, std::int64_t base_ns, RosEvents& into) {
  constexpr std::int64_t overflow_us = std::int64_t{1} << 31;
  std::int64_t carried_us = 0, previous = 0;
  into.events.reserve(data.size() / libcaer_event_bytes);
  for (std::size_t at = 0; at + libcaer_event_bytes <= data.size(); at += libcaer_event_bytes) {
    const auto place = number_at<std::uint32_t>(data, at);
    const std::int64_t us = number_at<std::uint32_t>(data, at + 4) & (overflow_us - 1);
    if (us + overflow_us / 2 < previous) carried_us += overflow_us;  // a small step back is disorder, not an overflow
    previous = us;
    add_event(into, base_ns / 1'000 + carried_us + us, place >> 17, place >> 2 & 0x7FFF, (place & 2) != 0);
  }
}

/// Words of 16 bits, with their kind in the upper four. Times count from the message's base.
void decode_compressed(Bytes data, std::int64_t base_ns, RosEvents& into) {
  enum Code : unsigned { time_high, time_low, address_x, address_y, vector_base_y, vector_8 };
  unsigned high = 0, low = 0, x = 0, base_y = 0;
  bool base_on = false;
  for (std::size_t at = 0; at + 2 <= data.size() && into.events.size() <= most_events; at += 2) {
    const unsigned word = number_at<std::uint16_t>(data, at);
    const unsigned value = word & 0x7FF;
    const bool upper_bit = (word & 0x800) != 0;
    const auto add = [&](unsigned y, bool on) {
      add_event(into, base_ns / 1'000 + static_cast<std::int64_t>(high << 12 | low), x, y, on);
    };
    switch (word >> 12) {
      case time_high:
        high = word & 0xFFF;
        break;
      case time_low:
        low = word & 0xFFF;
        break;
      case address_x:
        x = value;
        break;
      case address_y:
        add(value, upper_bit);
        break;
      case vector_base_y:
        base_y = value;
        base_on = upper_bit;
        break;
      case vector_8:
        for (unsigned bit = 0; bit < 8; ++bit) {
          if ((word >> bit & 1) != 0) add(base_y + bit, base_on);
        }
        base_y += 8;
        break;
      default:
        break;  // codes of a newer writer, without known events
    }
  }
}

/// 32 bits of nanoseconds, 16 of x, 15 of y, the polarity.
void decode_mono(Bytes data, std::int64_t base_ns, RosEvents& into) {
  into.events.reserve(data.size() / sizeof(std::uint64_t));
  for (std::size_t at = 0; at + sizeof(std::uint64_t) <= data.size(); at += sizeof(std::uint64_t)) {
    const auto word = number_at<std::uint64_t>(data, at);
    add_event(into, (base_ns + static_cast<std::int64_t>(word & 0xFFFFFFFF)) / 1'000, word >> 32 & 0xFFFF, word >> 48 & 0x7FFF,
              word >> 63 != 0);
  }
}

}  // namespace

bool take_size(RosFields& fields, events::SensorSize& size) {
  const auto height = fields.number<std::uint32_t>(), width = fields.number<std::uint32_t>();
  if (!fields.ok() || width < 1 || height < 1 || width > events::most_side || height > events::most_side) return false;
  size = {static_cast<int>(width), static_cast<int>(height)};
  return true;
}

bool decode_event_array(SerialisedMessage message, RosEvents& into) {
  into = {};
  RosFields fields(message);
  fields.header();
  if (!take_size(fields, into.size)) return false;
  const std::size_t events = fields.count(event_bytes);
  if (!fields.ok() || events > most_events) return false;
  into.events.reserve(events);
  for (std::size_t i = 0; i < events; ++i) {
    const auto x = fields.number<std::uint16_t>(), y = fields.number<std::uint16_t>();
    const std::int64_t t_us = fields.stamp_us();
    const bool on = fields.number<std::uint8_t>() != 0;
    if (!fields.ok()) return false;
    add_event(into, t_us, x, y, on);
  }
  return true;
}

PacketDecoding EventPacketDecoder::decode(SerialisedMessage message, RosEvents& into) {
  into = {};
  RosFields fields(message);
  fields.header();
  if (!take_size(fields, into.size)) return PacketDecoding::broken;
  const auto sequence = fields.number<std::uint64_t>(), base_ns = fields.number<std::uint64_t>();
  into.encoding = fields.text();
  const bool is_big_endian = fields.number<std::uint8_t>() != 0;
  const Bytes data = fields.array(1);
  if (!fields.ok() || base_ns > std::uint64_t{1} << 62) return PacketDecoding::broken;
  if (sequence_ && sequence > *sequence_ + 1) into.lost_packets = sequence - *sequence_ - 1;
  sequence_ = sequence;
  const auto base = static_cast<std::int64_t>(base_ns);
  const bool has_words = into.encoding == "libcaer_cmp" || into.encoding == "evt3";
  if (!has_words && data.size() / libcaer_event_bytes > most_events) return PacketDecoding::broken;
  if (is_big_endian) into.encoding += " (big-endian)";
  if (into.encoding == "libcaer") {
    decode_libcaer(data, base, into);
  } else if (into.encoding == "libcaer_cmp") {
    decode_compressed(data, base, into);
  } else if (into.encoding == "mono") {
    decode_mono(data, base, into);
  } else if (into.encoding == "evt3") {
    if (!decode_evt3(data, into)) return PacketDecoding::broken;
  } else {
    return PacketDecoding::other_encoding;
  }
  return into.events.size() > most_events ? PacketDecoding::broken : PacketDecoding::whole;
}

bool EventPacketDecoder::decode_evt3(Bytes data, RosEvents& into) {
  if (!evt3_ || evt3_size_ != into.size) evt3_.emplace(into.size);
  evt3_size_ = into.size;
  if (into.lost_packets > 0) evt3_->skip_gap();
  const events::Evt3Problems before = evt3_->problems();
  const std::size_t decoded = evt3_->decode(data, into.events, into.triggers, most_events);
  into.outside = evt3_->problems().outside - before.outside;
  into.unplaced = evt3_->problems().unplaced - before.unplaced;
  if (decoded == data.size()) return true;
  evt3_->skip_gap();
  return false;
}

}  // namespace tactile::bags
