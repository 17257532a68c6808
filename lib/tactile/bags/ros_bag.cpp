#include "tactile/bags/ros_bag.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <memory>
#include <string_view>
#include <vector>

#include "tactile/bags/bag_chunk.hpp"
#include "tactile/bags/bag_file.hpp"
#include "tactile/bags/ros_fields.hpp"
#include "tactile/core/error.hpp"
#include "tactile/events/packet_compression.hpp"

namespace tactile::bags {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view ros_bag_magic = "#ROSBAG V2.0\n";
constexpr std::uint32_t most_header = 1U << 20;
constexpr std::size_t most_connections = 65'536;

struct RosBagRecord {
  enum : unsigned { message_data = 0x02, bag_header = 0x03, chunk = 0x05, connection = 0x07 };
};

/// The value of a field in a record's header, which is a list of lengths and `name=value`s. Nothing if the field is missing, or a
/// field before it is broken.
std::optional<Bytes> field(Bytes header, std::string_view name) {
  while (header.size() >= 4) {
    const auto length = number_at<std::uint32_t>(header);
    if (length > header.size() - 4) return std::nullopt;
    const Bytes entry = header.subspan(4, length);
    const std::string_view text(reinterpret_cast<const char*>(entry.data()), entry.size());
    if (text.size() > name.size() && text.starts_with(name) && text[name.size()] == '=') return entry.subspan(name.size() + 1);
    header = header.subspan(4 + length);
  }
  return std::nullopt;
}

template <class T>
std::optional<T> number_field(Bytes header, std::string_view name) {
  const std::optional<Bytes> value = field(header, name);
  return value && value->size() == sizeof(T) ? std::optional(number_at<T>(*value)) : std::nullopt;
}

std::optional<std::string> text_field(Bytes header, std::string_view name) {
  const std::optional<Bytes> value = field(header, name);
  if (!value || value->size() > most_name) return std::nullopt;
  return std::string(reinterpret_cast<const char*>(value->data()), value->size());
}

}  // namespace

struct RosBagReader::State {
  explicit State(const fs::path& path) : file(path) {
    std::array<char, ros_bag_magic.size()> line{};
    file.read(0, std::as_writable_bytes(std::span(line)));
    if (std::string_view(line.data(), line.size()) == ros_bag_magic) return;
    throw Error(fmt::format("{}: does not begin with '{}'; expected a ROS 1 bag of version 2.0", file.name(),
                            ros_bag_magic.substr(0, ros_bag_magic.size() - 1)));
  }

  BagFile file;
  std::uint64_t at = ros_bag_magic.size();  ///< the next record of the file
  BagProblems problems;
  std::map<std::uint32_t, BagConnection> connections;
  std::vector<std::byte> header;
  events::PacketBuffer stored;
  BagChunk chunk_contents;
  Bytes rest;                ///< of the chunk being read
  bool is_rest_cut = false;  ///< the file ends inside that chunk, which is already counted

  struct Record {
    Bytes header;
    std::uint64_t data_at = 0;
    std::uint32_t data_size = 0;  ///< in the file
    bool is_cut = false;          ///< the file ends inside its data
  };

  /// The next record of the file, without its data; nothing if the file ends or is cut off, except inside a chunk.
  std::optional<Record> next_record() {
    const auto cut_off = [this] {
      problems.truncated_bytes = file.size() - at;
      at = file.size();
      return std::nullopt;
    };
    if (at >= file.size()) return std::nullopt;
    std::array<std::byte, 4> length{};
    if (file.size() - at < 8) return cut_off();
    file.read(at, length);
    const auto header_size = number_at<std::uint32_t>(length);
    if (header_size > most_header || header_size > file.size() - at - 8) return cut_off();
    header.resize(header_size);
    file.read(at + 4, header);
    file.read(at + 4 + header_size, length);
    Record record{.header = header, .data_at = at + 8 + header_size, .data_size = number_at<std::uint32_t>(length)};
    if (record.data_size > file.size() - record.data_at) {
      cut_off();
      if (number_field<std::uint8_t>(record.header, "op") != RosBagRecord::chunk) return std::nullopt;
      record.data_size = static_cast<std::uint32_t>(file.size() - record.data_at);
      record.is_cut = true;
      return record;
    }
    at = record.data_at + record.data_size;
    return record;
  }

  /// A record's data, at the front of `into`.
  Bytes data_of(const Record& record, events::PacketBuffer& into) const {
    into.grow(record.data_size, 0);
    const std::span<std::byte> bytes(into.data(), record.data_size);
    file.read(record.data_at, bytes);
    return bytes;
  }

  void keep_connection(Bytes record_header, Bytes data) {
    const auto id = number_field<std::uint32_t>(record_header, "conn");
    const auto topic = text_field(record_header, "topic"), type = text_field(data, "type"), md5sum = text_field(data, "md5sum");
    if (!id || !topic || !type || !md5sum || connections.size() == most_connections) {
      ++problems.broken_records;
    } else {
      connections.try_emplace(*id,
                              BagConnection{*topic, *type, *md5sum, ros_message_with(*md5sum)});  // the index repeats all of them
    }
  }

  std::optional<BagMessage> message_of(Bytes record_header, Bytes data) {
    const auto id = number_field<std::uint32_t>(record_header, "conn");
    const auto time = number_field<std::uint64_t>(record_header, "time");
    if (!id || !time) {
      ++problems.broken_records;
      return std::nullopt;
    }
    const auto found = connections.find(*id);
    if (found == connections.end()) {
      ++problems.unknown_messages;
      return std::nullopt;
    }
    const auto seconds = static_cast<std::int64_t>(*time & 0xFFFFFFFF), nanoseconds = static_cast<std::int64_t>(*time >> 32);
    return BagMessage{.connection = &found->second,
                      .received = HostTime{microseconds{seconds * 1'000'000 + nanoseconds / 1'000}},
                      .data = data};
  }

  /// Opens a chunk; `rest` then has its contents, or the readable front of an incomplete one. @return  whether that worked
  bool open_chunk(const Record& record) {
    const auto compression = text_field(record.header, "compression");
    const auto claimed = number_field<std::uint32_t>(record.header, "size");
    if (!compression || !claimed || *claimed > most_chunk || record.data_size > most_chunk) return false;
    is_rest_cut = record.is_cut;
    const auto contents = chunk_contents.contents(*compression, data_of(record, stored), *claimed, record.is_cut);
    rest = contents.value_or(Bytes());
    return contents.has_value();
  }

  /// The next message of the open chunk; nothing at its end.
  std::optional<BagMessage> next_in_chunk() {
    while (!rest.empty()) {
      const auto part = [this]() -> std::optional<Bytes> {
        if (rest.size() < 4) return std::nullopt;
        const auto length = number_at<std::uint32_t>(rest);
        if (length > rest.size() - 4) return std::nullopt;
        const Bytes bytes = rest.subspan(4, length);
        rest = rest.subspan(4 + length);
        return bytes;
      };
      const std::optional<Bytes> record_header = part();
      const std::optional<Bytes> data = record_header ? part() : std::nullopt;
      if (!data) {
        if (!is_rest_cut) ++problems.broken_chunks;
        rest = {};
        return std::nullopt;
      }
      const auto operation = number_field<std::uint8_t>(*record_header, "op");
      if (operation == RosBagRecord::connection) keep_connection(*record_header, *data);
      if (operation != RosBagRecord::message_data) continue;
      if (const auto message = message_of(*record_header, *data)) return message;
    }
    return std::nullopt;
  }

  std::optional<BagMessage> next() {
    for (;;) {
      if (const auto message = next_in_chunk()) return message;
      const std::optional<Record> record = next_record();
      if (!record) return std::nullopt;
      const auto operation = number_field<std::uint8_t>(record->header, "op");
      if (!operation) ++problems.broken_records;
      if (operation == RosBagRecord::bag_header) {
        if (!text_field(record->header, "encryptor").value_or("").empty())
          throw Error(file.name() + ": is encrypted; expected a plain bag");
      } else if (operation == RosBagRecord::chunk) {
        if (!open_chunk(*record) && !record->is_cut) ++problems.broken_chunks;
      } else if (operation == RosBagRecord::connection) {
        if (record->data_size > most_header) {
          ++problems.broken_records;
        } else {
          keep_connection(record->header, data_of(*record, stored));
        }
      } else if (operation == RosBagRecord::message_data) {
        if (record->data_size > most_chunk) {
          ++problems.broken_records;
        } else if (const auto message = message_of(record->header, data_of(*record, stored))) {
          return message;
        }
      }
    }
  }
};

RosBagReader::RosBagReader(const fs::path& file) : state_(std::make_unique<State>(file)) {}
RosBagReader::~RosBagReader() = default;

std::optional<BagMessage> RosBagReader::next() { return state_->next(); }

void RosBagReader::rewind() {
  state_->at = ros_bag_magic.size();
  state_->rest = {};
  state_->problems = {};
}

std::uint64_t RosBagReader::bytes_read() const { return state_->at; }
std::uint64_t RosBagReader::file_size() const { return state_->file.size(); }
const BagProblems& RosBagReader::problems() const { return state_->problems; }

}  // namespace tactile::bags
