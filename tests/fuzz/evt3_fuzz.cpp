#include <algorithm>

#include "abort_unless.hpp"
#include "tactile/events/evt3.hpp"

/// Events of any input are inside the sensor, and the same wherever the input is divided. The first two bytes choose the sensor
/// and the pieces.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactile::events;
  if (size < 2) return 0;
  const SensorSize sensor{8 * data[0] + 1, 8 * data[0] + 1};
  const std::size_t piece = data[1] + std::size_t{1};
  const auto bytes = std::as_bytes(std::span(data + 2, size - 2));
  std::vector<Event> events, in_pieces;
  std::vector<Evt3Trigger> triggers, triggers_in_pieces;
  Evt3Decoder decoder(sensor), decoder_of_pieces(sensor);
  tactile::test::abort_unless(decoder.decode(bytes, events, triggers) == bytes.size());
  for (std::size_t at = 0; at < bytes.size(); at += piece)
    decoder_of_pieces.decode(bytes.subspan(at, std::min(piece, bytes.size() - at)), in_pieces, triggers_in_pieces);
  tactile::test::abort_unless(events == in_pieces && triggers == triggers_in_pieces);
  tactile::test::abort_unless(decoder.problems() == decoder_of_pieces.problems());
  for (const Event& event : events)
    tactile::test::abort_unless(event.x >= 0 && event.x < sensor.width && event.y >= 0 && event.y < sensor.height &&
                                event.on <= 1);
  return 0;
}
