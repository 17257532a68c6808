#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "tactile/core/error.hpp"
#include "tactile/network/dv_stream_parser.hpp"

/// What keeps the compiler from leaving out the reading.
volatile std::int64_t seen = 0;

/// Whatever a server sends, and however it is cut, the client's parser either reads it or says in an Error why it cannot. The
/// first byte says how it is cut.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactile;
  if (size == 0) return 0;
  const std::size_t most = data[0] == 0 ? size : data[0];
  std::span<const std::uint8_t> left(data + 1, size - 1);
  try {
    DvStreamParser parser("stream");
    while (!left.empty()) {
      const std::span<std::byte> room = parser.room();
      const std::size_t count = std::min({room.size(), left.size(), most});
      std::memcpy(room.data(), left.data(), count);
      left = left.subspan(count);
      if (!parser.received(count)) continue;
      std::int64_t sum = 0;  // every element is touched
      for (const Event& event : parser.events()) sum ^= us_of(event.t) + event.x + event.y + event.on;
      for (const ImuSample& sample : parser.imu()) sum ^= us_of(sample.t);
      for (const Trigger& trigger : parser.triggers()) sum ^= us_of(trigger.t) + trigger.type;
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
