#include <fstream>

#include "abort_unless.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/bags/bag.hpp"
#include "tactile/bags/ros_events.hpp"
#include "tactile/core/error.hpp"

namespace {

using namespace tactile;
using test::abort_unless;

/// Reads all messages, and decodes the events in them. @return  their count
std::uint64_t read_all(bags::BagReader& bag) {
  std::uint64_t messages = 0, before = 0;
  bags::EventPacketDecoder packets;
  bags::RosEvents events;
  while (const auto message = bag.next()) {
    ++messages;
    if (message->connection->message == bags::RosMessage::event_array) bags::decode_event_array(message->serialised(), events);
    if (message->connection->message == bags::RosMessage::event_packet) packets.decode(message->serialised(), events);
    for (const events::Event& event : events.events)
      abort_unless(event.x >= 0 && event.y >= 0 && event.x < events.size.width && event.y < events.size.height && event.on <= 1);
    abort_unless(bag.bytes_read() >= before && bag.bytes_read() <= bag.file_size());
    before = bag.bytes_read();
  }
  return messages;
}

}  // namespace

/// For any input, the bag is read twice with the same result, or there is an Error. The file has a name, which SQLite needs.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const test::TemporaryFolder folder;
  const auto file = folder / "bag";
  std::ofstream(file, std::ios::binary).write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  try {
    const auto bag = bags::open_bag(file);
    const std::uint64_t messages = read_all(*bag);
    bag->rewind();
    abort_unless(read_all(*bag) == messages);
  } catch (const Error&) {
  }
  return 0;
}
