#pragma once

#include <lz4frame.h>
#include <zstd.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "tactile/events/event.hpp"

// AEDAT4 files byte by byte, made without the code under test, to be cut, patched and filled with what no sound writer makes.
namespace tactile::test {

inline std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

inline std::filesystem::path write_bytes(const std::filesystem::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return file;
}

template <class T>
T get(const std::string& bytes, std::size_t at) {
  T value{};
  if (at + sizeof value > bytes.size()) throw std::out_of_range("get");
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

template <class T>
void put(std::string& bytes, std::size_t at, T value) {
  if (at + sizeof value > bytes.size()) throw std::out_of_range("put");
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

template <class T>
void append(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// Sets the size prefix of a FlatBuffer to what it must be.
inline std::string prefixed(std::string bytes) {
  put(bytes, 0, static_cast<std::uint32_t>(bytes.size() - 4));
  return bytes;
}

// --- taking a file apart -------------------------------------------------------------------------------------------------------

constexpr std::size_t position_at = 54;  ///< where the vendor's files, and those made here, have the table's position

struct PacketPlace {
  std::int32_t id = 0;
  std::size_t at = 0;    ///< of its header
  std::size_t size = 0;  ///< of its payload
  std::size_t end() const { return at + 8 + size; }
};

struct FileLayout {
  std::size_t data_begin = 0;
  std::size_t table_at = 0;
  std::vector<PacketPlace> packets;
};

inline FileLayout layout_of(const std::string& bytes) {
  FileLayout layout;
  layout.data_begin = 18 + get<std::uint32_t>(bytes, 14);
  layout.table_at = static_cast<std::size_t>(get<std::int64_t>(bytes, position_at));
  for (std::size_t at = layout.data_begin; at < layout.table_at; at = layout.packets.back().end()) {
    layout.packets.push_back({.id = get<std::int32_t>(bytes, at), .at = at, .size = get<std::uint32_t>(bytes, at + 4)});
  }
  return layout;
}

// --- making one
// ------------------------------------------------------------------------------------------------------------------

inline std::string event_node(int id, int width, int height, const std::string& source) {
  const std::string name = std::to_string(id);
  return "<node name=\"" + name + "\" path=\"/outInfo/" + name + "/\">" +
         "<attr key=\"originalOutputName\" type=\"string\">events</attr>" +
         "<attr key=\"typeIdentifier\" type=\"string\">EVTS</attr>" + "<node name=\"info\" path=\"/outInfo/" + name +
         "/info/\">" + "<attr key=\"sizeX\" type=\"int\">" + std::to_string(width) + "</attr>" +
         "<attr key=\"sizeY\" type=\"int\">" + std::to_string(height) + "</attr>" + "<attr key=\"source\" type=\"string\">" +
         source + "</attr></node></node>";
}

inline std::string plain_node(int id, const std::string& identifier) {
  return "<node name=\"" + std::to_string(id) + "\"><attr key=\"typeIdentifier\" type=\"string\">" + identifier +
         "</attr></node>";
}

inline std::string xml_of(const std::string& nodes, const std::string& version = "2.0") {
  return "<dv version=\"" + version + "\"><node name=\"outInfo\" path=\"/outInfo/\">" + nodes + "</node></dv>\n";
}

/// Magic line and header, with no table yet.
inline std::string file_start(int compression, const std::string& xml, const std::string& identifier = "IOHE") {
  std::string header(52, '\0');
  put(header, 4, std::uint32_t{24});
  header.replace(8, 4, identifier);
  put(header, 18, std::uint16_t{10});
  put(header, 20, std::uint16_t{20});
  put(header, 22, std::uint16_t{4});
  put(header, 24, std::uint16_t{12});
  put(header, 26, std::uint16_t{8});
  put(header, 28, std::int32_t{10});
  put(header, 32, std::int32_t{compression});
  put(header, 36, std::uint32_t{12});
  put(header, 40, std::int64_t{-1});
  put(header, 48, static_cast<std::uint32_t>(xml.size()));
  header += xml;
  header += '\0';
  while (header.size() % 4 != 0) header += '\0';
  return "#!AER-DAT4.0\r\n" + prefixed(header);
}

inline std::string event_payload(const std::vector<events::Event>& events) {
  std::string payload(32, '\0');
  put(payload, 4, std::uint32_t{16});
  payload.replace(8, 4, "EVTS");
  put(payload, 14, std::uint16_t{6});
  put(payload, 16, std::uint16_t{8});
  put(payload, 18, std::uint16_t{4});
  put(payload, 20, std::int32_t{6});
  put(payload, 24, std::uint32_t{4});
  put(payload, 28, static_cast<std::uint32_t>(events.size()));
  for (const events::Event& event : events) payload.append(reinterpret_cast<const char*>(&event), sizeof event);
  return prefixed(payload);
}

inline std::string packet(std::int32_t id, const std::string& payload) {
  std::string bytes;
  append(bytes, id);
  append(bytes, static_cast<std::uint32_t>(payload.size()));
  return bytes + payload;
}

struct TableEntry {
  std::int64_t offset = 0;
  std::int32_t id = 0;
  std::int32_t size = 0;
  std::int64_t elements = 0, first = 0, last = 0;
};

/// A data table, not compressed.
inline std::string table_of(const std::vector<TableEntry>& entries) {
  std::string table(32, '\0');
  put(table, 4, std::uint32_t{16});
  table.replace(8, 4, "FTAB");
  put(table, 14, std::uint16_t{6});
  put(table, 16, std::uint16_t{8});
  put(table, 18, std::uint16_t{4});
  put(table, 20, std::int32_t{6});
  put(table, 24, std::uint32_t{4});
  put(table, 28, static_cast<std::uint32_t>(entries.size()));
  const std::size_t offsets = table.size();
  table.resize(offsets + 4 * entries.size());
  const std::size_t vtable = table.size();
  for (const std::uint16_t field : std::to_array<std::uint16_t>({14, 44, 4, 36, 12, 20, 28})) append(table, field);
  while (table.size() % 8 != 4) table += '\0';
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const std::size_t at = table.size();
    put(table, offsets + 4 * i, static_cast<std::uint32_t>(at - offsets - 4 * i));
    append(table, static_cast<std::int32_t>(at - vtable));
    append(table, entries[i].offset);
    append(table, entries[i].elements);
    append(table, entries[i].first);
    append(table, entries[i].last);
    append(table, entries[i].id);
    append(table, entries[i].size);
    append(table, std::int32_t{0});
  }
  return prefixed(table);
}

/// `bytes`, followed by a table that the header points to.
inline std::string with_table(std::string bytes, const std::string& table) {
  put(bytes, position_at, static_cast<std::int64_t>(bytes.size()));
  return bytes + table;
}

struct Lz4Kind {
  LZ4F_blockSizeID_t block = LZ4F_max64KB;
  LZ4F_blockMode_t mode = LZ4F_blockLinked;
  bool checksums = false;
};

inline std::string lz4(const std::string& content, Lz4Kind kind = {}) {
  LZ4F_preferences_t preferences{};
  preferences.frameInfo.blockSizeID = kind.block;
  preferences.frameInfo.blockMode = kind.mode;
  if (kind.checksums) {
    preferences.frameInfo.contentChecksumFlag = LZ4F_contentChecksumEnabled;
    preferences.frameInfo.blockChecksumFlag = LZ4F_blockChecksumEnabled;
    preferences.frameInfo.contentSize = content.size();
  }
  std::string frame(LZ4F_HEADER_SIZE_MAX + LZ4F_compressBound(content.size(), &preferences), '\0');
  LZ4F_cctx* context = nullptr;
  LZ4F_createCompressionContext(&context, LZ4F_VERSION);
  std::size_t size = LZ4F_compressBegin(context, frame.data(), frame.size(), &preferences);
  size += LZ4F_compressUpdate(context, frame.data() + size, frame.size() - size, content.data(), content.size(), nullptr);
  size += LZ4F_compressEnd(context, frame.data() + size, frame.size() - size, nullptr);
  LZ4F_freeCompressionContext(context);
  frame.resize(size);
  return frame;
}

inline std::string zstd(const std::string& content) {
  std::string frame(ZSTD_compressBound(content.size()), '\0');
  frame.resize(ZSTD_compress(frame.data(), frame.size(), content.data(), content.size(), 3));
  return frame;
}

/// As a streaming encoder writes it, which does not know the content's size when it begins.
inline std::string zstd_without_size(const std::string& content) {
  std::string frame(ZSTD_compressBound(content.size()) + 64, '\0');
  ZSTD_CCtx* context = ZSTD_createCCtx();
  ZSTD_inBuffer in{content.data(), content.size(), 0};
  ZSTD_outBuffer out{frame.data(), frame.size(), 0};
  while (in.pos < in.size) ZSTD_compressStream2(context, &out, &in, ZSTD_e_continue);
  while (ZSTD_compressStream2(context, &out, &in, ZSTD_e_end) != 0) {
  }
  ZSTD_freeCCtx(context);
  frame.resize(out.pos);
  return frame;
}

inline events::Event event(std::int64_t t, int x, int y, int on) {
  return {.t = camera_time(t),
          .x = static_cast<std::int16_t>(x),
          .y = static_cast<std::int16_t>(y),
          .on = static_cast<std::uint8_t>(on)};
}

}  // namespace tactile::test
