#include "tactile/bags/mcap_bag.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <map>

#include "tactile/bags/bag_chunk.hpp"
#include "tactile/bags/bag_file.hpp"
#include "tactile/bags/ros_fields.hpp"
#include "tactile/core/error.hpp"

namespace tactile::bags {
namespace fs = std::filesystem;
namespace {

constexpr std::array<std::byte, 8> mcap_magic{std::byte{0x89}, std::byte{'M'}, std::byte{'C'},  std::byte{'A'},
                                              std::byte{'P'},  std::byte{'0'}, std::byte{'\r'}, std::byte{'\n'}};
constexpr std::size_t record_head = 9;           // the operation, then the length in 8 bytes
constexpr std::uint64_t most_small = 16U << 20;  // of the record of a schema or channel
constexpr std::size_t most_entries = 4096;       // schemas, channels
constexpr std::size_t most_chunk_head = 8 + 8 + 8 + 4 + 4 + 64 + 8;

struct McapRecord {
  enum : unsigned { footer = 0x02, schema = 0x03, channel = 0x04, message = 0x05, chunk = 0x06, data_end = 0x0F };
};

/// MCAP's numbers have no gaps between them, as those of ROS 1.
std::optional<std::string> name_in(RosFields& fields) {
  const std::string_view text = fields.text();
  return fields.ok() && text.size() <= most_name ? std::optional(std::string(text)) : std::nullopt;
}

RosSerialisation serialisation_named(std::string_view encoding) {
  if (encoding == "cdr") return RosSerialisation::cdr;
  return encoding == "ros1" ? RosSerialisation::ros1 : RosSerialisation::other;
}

}  // namespace

struct McapReader::State {
  explicit State(const fs::path& path) : file(path) {
    std::array<std::byte, mcap_magic.size()> begin{};
    file.read(0, begin);
    if (begin != mcap_magic) throw Error(file.name() + ": does not begin as an MCAP file; expected one of version 0");
  }

  BagFile file;
  std::uint64_t at = mcap_magic.size();  ///< the next record of the file
  BagProblems problems;
  std::map<std::uint16_t, std::string> schemas;  ///< types by id
  std::map<std::uint16_t, BagConnection> channels;
  events::PacketBuffer stored;
  BagChunk chunk_contents;
  Bytes rest;                ///< of the chunk being read
  bool is_rest_cut = false;  ///< the file ends inside that chunk, which is already counted

  struct Record {
    unsigned operation = 0;
    std::uint64_t data_at = 0, data_size = 0;  ///< in the file
    bool is_cut = false;                       ///< the file ends inside its data
  };

  /// The next record of the file, without its data; nothing if the file ends or is cut off, except inside a chunk.
  std::optional<Record> next_record() {
    if (at >= file.size()) return std::nullopt;
    std::array<std::byte, record_head> head{};
    const std::uint64_t left = file.size() - at;
    if (left >= record_head) file.read(at, head);
    Record record{.operation = std::to_integer<unsigned>(head[0]),
                  .data_at = at + record_head,
                  .data_size = number_at<std::uint64_t>(head, 1)};
    // Zeros follow if the file was longer than what had reached the disk.
    if (left >= record_head && record.operation != 0 && record.data_size <= left - record_head) {
      at = record.data_at + record.data_size;
      return record;
    }
    problems.truncated_bytes += left;
    at = file.size();
    if (left < record_head || record.operation != McapRecord::chunk) return std::nullopt;
    record.data_size = left - record_head;
    record.is_cut = true;
    return record;
  }

  /// A record's data from `begin` on.
  Bytes data_of(const Record& record, std::uint64_t begin = 0) {
    const auto size = static_cast<std::size_t>(record.data_size - begin);
    stored.grow(size, 0);
    const std::span<std::byte> bytes(stored.data(), size);
    file.read(record.data_at + begin, bytes);
    return bytes;
  }

  void keep_schema(Bytes data) {
    RosFields fields(data);
    const auto id = fields.number<std::uint16_t>();
    const auto name = name_in(fields);
    if (name && (schemas.size() < most_entries || schemas.contains(id))) {
      schemas[id] = *name;
    } else {
      ++problems.broken_records;
    }
  }

  void keep_channel(Bytes data) {
    RosFields fields(data);
    const auto id = fields.number<std::uint16_t>(), schema_id = fields.number<std::uint16_t>();
    const auto topic = name_in(fields), encoding = topic ? name_in(fields) : std::nullopt;
    if (!encoding || (channels.size() >= most_entries && !channels.contains(id))) {
      ++problems.broken_records;
      return;
    }
    const auto type = schemas.find(schema_id);
    BagConnection connection{.topic = *topic, .type = type == schemas.end() ? "" : type->second};
    connection.serialisation = serialisation_named(*encoding);
    if (connection.serialisation != RosSerialisation::other) connection.message = ros_message_named(connection.type);
    channels.insert_or_assign(id, connection);
  }

  std::optional<BagMessage> message_of(Bytes data) {
    RosFields fields(data);
    const auto id = fields.number<std::uint16_t>();
    fields.number<std::uint32_t>();  // sequence
    const auto received_ns = fields.number<std::uint64_t>();
    fields.number<std::uint64_t>();  // published
    if (!fields.ok()) {
      ++problems.broken_records;
      return std::nullopt;
    }
    const auto found = channels.find(id);
    if (found == channels.end()) {
      ++problems.unknown_messages;
      return std::nullopt;
    }
    return BagMessage{.connection = &found->second,
                      .received = HostTime{microseconds{static_cast<std::int64_t>(received_ns / 1'000)}},
                      .data = data.subspan(2 + 4 + 8 + 8)};
  }

  /// Opens a chunk; `rest` then has its contents, or the readable front of an incomplete one. @return  whether that worked
  bool open_chunk(const Record& record) {
    std::array<std::byte, most_chunk_head> head{};
    const auto head_size = static_cast<std::size_t>(std::min<std::uint64_t>(head.size(), record.data_size));
    file.read(record.data_at, std::span(head).first(head_size));
    RosFields fields(Bytes(head).first(head_size));
    fields.take(16);  // times of its first and last message
    const auto claimed = fields.number<std::uint64_t>();
    const auto checksum = fields.number<std::uint32_t>();
    const std::string method(fields.text());
    const auto records_size = fields.number<std::uint64_t>();
    const std::uint64_t begin = 8 + 8 + 8 + 4 + 4 + method.size() + 8;
    if (!fields.ok() || claimed > most_chunk || record.data_size - begin > most_chunk) return false;
    if (!record.is_cut && records_size != record.data_size - begin) return false;
    const auto contents =
        chunk_contents.contents(method, data_of(record, begin), static_cast<std::size_t>(claimed), record.is_cut);
    if (!contents) return false;
    if (!record.is_cut && checksum != 0 &&
        ::crc32_z(0, reinterpret_cast<const unsigned char*>(contents->data()), contents->size()) != checksum)
      return false;
    rest = *contents;
    is_rest_cut = record.is_cut;
    return true;
  }

  /// The next message of the open chunk; nothing at its end.
  std::optional<BagMessage> next_in_chunk() {
    while (!rest.empty()) {
      if (rest.size() < record_head || number_at<std::uint64_t>(rest, 1) > rest.size() - record_head) {
        if (!is_rest_cut) ++problems.broken_chunks;
        rest = {};
        break;
      }
      const auto operation = std::to_integer<unsigned>(rest[0]);
      const auto size = static_cast<std::size_t>(number_at<std::uint64_t>(rest, 1));
      const Bytes data = rest.subspan(record_head, size);
      rest = rest.subspan(record_head + size);
      if (const auto found = take(operation, data)) return found;
    }
    return std::nullopt;
  }

  std::optional<BagMessage> take(unsigned operation, Bytes data) {
    if (operation == McapRecord::schema) keep_schema(data);
    if (operation == McapRecord::channel) keep_channel(data);
    return operation == McapRecord::message ? message_of(data) : std::nullopt;
  }

  std::optional<BagMessage> next() {
    for (;;) {
      if (const auto found = next_in_chunk()) return found;
      const std::optional<Record> record = next_record();
      if (!record) return std::nullopt;
      if (record->operation == McapRecord::data_end || record->operation == McapRecord::footer) {
        at = file.size();  // only the summary follows
        return std::nullopt;
      }
      if (record->operation == McapRecord::chunk) {
        if (!open_chunk(*record) && !record->is_cut) ++problems.broken_chunks;
        continue;
      }
      const bool is_entry = record->operation == McapRecord::schema || record->operation == McapRecord::channel;
      if (!is_entry && record->operation != McapRecord::message) continue;
      if (record->data_size > (is_entry ? most_small : most_chunk)) {
        ++problems.broken_records;
      } else if (const auto found = take(record->operation, data_of(*record))) {
        return found;
      }
    }
  }
};

McapReader::McapReader(const fs::path& file) : state_(std::make_unique<State>(file)) {}
McapReader::~McapReader() = default;

std::optional<BagMessage> McapReader::next() { return state_->next(); }

void McapReader::rewind() {
  state_->at = mcap_magic.size();
  state_->rest = {};
  state_->problems = {};
}

std::uint64_t McapReader::bytes_read() const { return state_->at; }
std::uint64_t McapReader::file_size() const { return state_->file.size(); }
const BagProblems& McapReader::problems() const { return state_->problems; }

}  // namespace tactile::bags
