#include "tactile/bags/bag_contents.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <map>
#include <memory>

#include "tactile/bags/bag_file.hpp"
#include "tactile/bags/ros_events.hpp"
#include "tactile/core/error.hpp"

namespace tactile::bags {
namespace {

constexpr std::size_t most_decoders = 64;  // of topics with packets of events; further ones are listed only

struct Topic {
  TopicContents contents;
  std::unique_ptr<EventPacketDecoder> packets;
};

void add_events(TopicContents& contents, const RosEvents& decoded) {
  if (!contents.size) contents.size = decoded.size;
  if (contents.encoding.empty()) contents.encoding = decoded.encoding.substr(0, 64);
  contents.outside += decoded.outside;
  contents.unplaced += decoded.unplaced;
  if (__builtin_add_overflow(contents.lost_packets, decoded.lost_packets, &contents.lost_packets))
    contents.lost_packets = std::numeric_limits<std::uint64_t>::max();
  contents.triggers += decoded.triggers.size();
  for (const events::Event& event : decoded.events) {
    if (contents.events++ == 0) contents.first = contents.last = event.t;
    contents.first = std::min(contents.first, event.t);
    contents.last = std::max(contents.last, event.t);
    contents.on_events += event.on;
  }
}

void take(Topic& topic, const BagMessage& message, RosEvents& decoded) {
  TopicContents& contents = topic.contents;
  const RosMessage type = message.connection->message;
  bool is_whole = true;
  if (type == RosMessage::event_array) is_whole = decode_event_array(message.serialised(), decoded);
  if (type == RosMessage::event_packet && topic.packets) {
    const PacketDecoding decoding = topic.packets->decode(message.serialised(), decoded);
    is_whole = decoding != PacketDecoding::broken;
  } else if (type != RosMessage::event_array) {
    return;
  }
  contents.has_events = true;
  if (is_whole) {
    add_events(contents, decoded);
  } else {
    ++contents.broken_messages;
  }
}

}  // namespace

BagContents read_bag_contents(const std::filesystem::path& place, const ProgressCallback& progress) {
  const std::unique_ptr<BagReader> bag = open_bag(place);
  std::map<std::string, Topic> topics;
  std::size_t decoders = 0;
  RosEvents decoded;
  while (const auto message = bag->next()) {
    const BagConnection& connection = *message->connection;
    if (topics.size() == most_topics && !topics.contains(connection.topic))
      throw Error(fmt::format("{}: has more than {} topics; expected fewer", place.string(), most_topics));
    Topic& topic = topics[connection.topic];
    TopicContents& contents = topic.contents;
    if (contents.messages++ == 0) {
      contents.name = connection.topic;
      contents.type = connection.type;
      contents.first_received = contents.last_received = message->received;
      if (connection.message == RosMessage::event_packet && decoders++ < most_decoders)
        topic.packets = std::make_unique<EventPacketDecoder>();
    }
    contents.first_received = std::min(contents.first_received, message->received);
    contents.last_received = std::max(contents.last_received, message->received);
    take(topic, *message, decoded);
    report_progress(progress, bag->bytes_read(), bag->file_size(), place.filename().string());
  }
  BagContents found{.format = std::string(bag->format()),
                    .files = files_of_bag(place).size(),
                    .bytes = bag->file_size(),
                    .topics = {},
                    .problems = bag->problems()};
  for (auto& [name, topic] : topics) found.topics.push_back(std::move(topic.contents));
  return found;
}

}  // namespace tactile::bags
