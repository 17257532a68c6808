#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "tactile/core/error.hpp"
#include "tactile/transport/dv/dv_stream_parser.hpp"

/// Keeps the compiler from removing the reads.
volatile std::int64_t seen = 0;

/// For any stream in pieces of any size, the parser of the client reads it, or there is an Error. The first byte is the size of
/// the pieces, 0 for one piece.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactile;
  if (size == 0) return 0;
  const std::size_t piece = data[0] == 0 ? size : data[0];
  std::span<const std::uint8_t> left(data + 1, size - 1);
  try {
    transport::DvStreamParser parser("stream");
    while (!left.empty()) {
      const std::span<std::byte> room = parser.room();
      const std::size_t count = std::min({room.size(), left.size(), piece});
      std::memcpy(room.data(), left.data(), count);
      left = left.subspan(count);
      if (!parser.received(count)) continue;
      std::int64_t sum = 0;  // every element is read
      for (const events::Event& event : parser.events()) sum ^= us_of(event.t) + event.x + event.y + event.on;
      for (const events::ImuSample& sample : parser.imu()) sum ^= us_of(sample.t);
      for (const events::Trigger& trigger : parser.triggers()) sum ^= us_of(trigger.t) + trigger.type;
      if (parser.frame()) {
        for (const std::uint8_t pixel : parser.frame()->pixels) sum ^= pixel;
      }
      seen = sum;
    }
    parser.end();
  } catch (const Error&) {
  }
  return 0;
}
