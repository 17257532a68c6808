#include <array>

#include "abort_unless.hpp"
#include "bytes_as_file.hpp"
#include "tactile/core/error.hpp"
#include "tactile/events/event_csv.hpp"

/// For any input, events are read whose times never fall and that lie inside the sensor, or there is an Error. The first byte of
/// the input selects the options.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactile;
  using test::abort_unless;
  if (size == 0) return 0;
  constexpr std::array<const char*, 4> columns{"", "t,x,y,p", "x,y,-,p,t", "t,q"};
  events::EventCsvOptions options{.columns = columns[data[0] % 4], .time_unit = {}};
  if (const unsigned unit = data[0] / 4 % 8; unit < 4) options.time_unit = static_cast<events::TimeUnit>(unit);
  const test::BytesAsFile file(data + 1, size - 1);
  constexpr events::SensorSize sensor{640, 480};
  try {
    events::EventCsvReader reader(file.path(), sensor, options);
    CameraTime latest = CameraTime::min();
    for (auto chunk = reader.next(); !chunk.empty(); chunk = reader.next()) {
      for (const events::Event& event : chunk) {
        abort_unless(event.t >= latest && event.x >= 0 && event.x < sensor.width && event.y >= 0 && event.y < sensor.height);
        abort_unless(event.on <= 1);
        latest = event.t;
      }
    }
  } catch (const Error&) {
  }
  return 0;
}
