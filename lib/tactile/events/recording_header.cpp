#include "tactile/events/recording_header.hpp"

#include <flatbuffers/flatbuffers.h>
#include <fmt/core.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <map>
#include <pugixml.hpp>
#include <sstream>

#include "io_header_generated.h"
#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"

namespace tactile::events {
namespace {

constexpr std::string_view compression_attributes[] = {"NONE", "LZ4", "LZ4_HIGH", "ZSTD", "ZSTD_HIGH"};

pugi::xml_node node_named(const pugi::xml_node& parent, std::string_view name) {
  for (const pugi::xml_node node : parent.children("node")) {
    if (node.attribute("name").value() == name) return node;
  }
  return {};
}

std::string attribute(const pugi::xml_node& node, std::string_view key) {
  for (const pugi::xml_node attr : node.children("attr")) {
    if (attr.attribute("key").value() == key) return attr.text().get();
  }
  return {};
}

std::optional<std::int32_t> int32_in(std::string_view text) {
  const auto number = whole_number_in(text);
  if (!number || *number < std::numeric_limits<std::int32_t>::min() || *number > std::numeric_limits<std::int32_t>::max())
    return {};
  return static_cast<std::int32_t>(*number);
}

Stream stream_in(const pugi::xml_node& node, std::int32_t id) {
  Stream stream;
  stream.id = id;
  stream.type_identifier = attribute(node, "typeIdentifier");
  stream.type = type_identified(stream.type_identifier);
  stream.name = attribute(node, "originalOutputName");
  const pugi::xml_node info = node_named(node, "info");
  std::int32_t width = 0;
  std::int32_t height = 0;
  for (const pugi::xml_node attr : info.children("attr")) {
    const std::string_view key = attr.attribute("key").value();
    const std::string text = attr.text().get();
    if (key == "sizeX") {
      width = int32_in(text).value_or(0);
    } else if (key == "sizeY") {
      height = int32_in(text).value_or(0);
    } else if (key == "source") {
      stream.source = text;
    } else if (!key.empty()) {
      stream.info.emplace_back(key, text);
    }
  }
  if (width > 0 && height > 0) stream.size = SensorSize{.width = width, .height = height};
  return stream;
}

/// The streams in the order of their declaration. A node without a type, or whose name is not a number, is no stream. Of two with
/// the same id the first counts.
std::vector<Stream> streams_in(std::string_view xml, std::string_view where) {
  pugi::xml_document document;
  const auto parsed = document.load_buffer(xml.data(), xml.size(), pugi::parse_default, pugi::encoding_utf8);
  if (!parsed) {
    throw Error(std::string(where) + ": the XML in its header does not parse (" + parsed.description() +
                "); expected what DV writes");
  }
  std::vector<Stream> streams;
  for (const pugi::xml_node node : node_named(document.child("dv"), "outInfo").children("node")) {
    const auto id = int32_in(node.attribute("name").value());
    if (!id || attribute(node, "typeIdentifier").empty()) continue;
    if (std::any_of(streams.begin(), streams.end(), [&](const Stream& s) { return s.id == *id; })) continue;
    streams.push_back(stream_in(node, *id));
  }
  return streams;
}

struct TypedText {
  std::string_view type;
  std::string text;
};

std::string_view type_of(std::string_view text) {
  if (int32_in(text)) return "int";
  return whole_number_in(text) ? "long" : "string";
}

/// Attributes in the order of their keys, as DV's own configuration tree has them.
void append_attributes(pugi::xml_node& node, const std::map<std::string, TypedText>& attributes) {
  for (const auto& [key, value] : attributes) {
    pugi::xml_node attr = node.append_child("attr");
    attr.append_attribute("key") = key.c_str();
    attr.append_attribute("type") = std::string(value.type).c_str();
    attr.text() = value.text.c_str();
  }
}

pugi::xml_node append_node(pugi::xml_node& parent, const std::string& name, const std::string& path) {
  pugi::xml_node node = parent.append_child("node");
  node.append_attribute("name") = name.c_str();
  node.append_attribute("path") = path.c_str();
  return node;
}

std::string_view description_of(StreamType type) {
  switch (type) {
    case StreamType::events:
      return "Array of events (polarity ON/OFF).";
    case StreamType::frames:
      return "Standard frame (8-bit image).";
    case StreamType::imu:
      return "Inertial Measurement Unit data samples.";
    case StreamType::triggers:
      return "External triggers and special signals.";
    case StreamType::other:
      break;
  }
  return "";
}

std::string xml_of(Compression compression, std::vector<Stream> streams) {
  std::sort(streams.begin(), streams.end(), [](const Stream& a, const Stream& b) { return a.id < b.id; });
  const std::string path = "/mainloop/Recorder/outInfo/";
  pugi::xml_document document;
  pugi::xml_node root = document.append_child("dv");
  root.append_attribute("version") = "2.0";
  pugi::xml_node out_info = append_node(root, "outInfo", path);
  for (const Stream& stream : streams) {
    const std::string id = std::to_string(stream.id);
    pugi::xml_node node = append_node(out_info, id, path + id + "/");
    append_attributes(
        node,
        {{"compression", {"string", std::string(compression_attributes[static_cast<std::size_t>(compression)])}},
         {"originalModuleName", {"string", "tactile"}},
         {"originalOutputName", {"string", stream.name}},
         {"typeDescription", {"string", std::string(description_of(stream.type))}},
         {"typeIdentifier",
          {"string", stream.type == StreamType::other ? stream.type_identifier : std::string(identifier_of(stream.type))}}});
    std::map<std::string, TypedText> info{{"source", {"string", stream.source}}};
    for (const auto& [key, text] : stream.info) info.emplace(key, TypedText{type_of(text), text});
    if (stream.size) {
      info["sizeX"] = {"int", std::to_string(stream.size->width)};
      info["sizeY"] = {"int", std::to_string(stream.size->height)};
    }
    pugi::xml_node info_node = append_node(node, "info", path + id + "/info/");
    append_attributes(info_node, info);
  }
  std::ostringstream text;
  document.save(text, "    ", pugi::format_indent | pugi::format_no_declaration, pugi::encoding_utf8);
  return text.str();
}

}  // namespace

void check_readable_by_vendor(const Stream& stream, std::string_view where) {
  const auto refuse = [&](std::string_view why) { throw Error(fmt::format("{}: stream {} {}", where, stream.id, why)); };
  if (stream.id < 0) refuse("has a negative id; expected 0 or more");
  if (stream.type == StreamType::other) refuse("is of another type; expected events, frames, imu or triggers");
  if (!stream.type_identifier.empty() && stream.type_identifier != identifier_of(stream.type))
    refuse(fmt::format("names its type {}; expected {}", stream.type_identifier, identifier_of(stream.type)));
  if (stream.name.empty()) refuse("has no name; expected one such as 'events'");
  if (stream.source.empty()) refuse("has no source; expected the camera's, such as 'DVXplorer_DXA00000'");
  if (stream.type != StreamType::events && stream.type != StreamType::frames) return;
  const SensorSize size = stream.size.value_or(SensorSize{});
  if (size.width < 1 || size.height < 1 || size.width > most_side || size.height > most_side)
    refuse(fmt::format("has a size of {} x {}; expected 1 to {} pixels each way", size.width, size.height, most_side));
}

StreamType type_identified(std::string_view identifier) {
  for (const StreamType type : {StreamType::events, StreamType::frames, StreamType::imu, StreamType::triggers}) {
    if (identifier == identifier_of(type)) return type;
  }
  return StreamType::other;
}

std::string_view identifier_of(StreamType type) {
  switch (type) {
    case StreamType::events:
      return "EVTS";
    case StreamType::frames:
      return "FRME";
    case StreamType::imu:
      return "IMUS";
    case StreamType::triggers:
      return "TRIG";
    case StreamType::other:
      break;
  }
  return {};
}

RecordingHeader read_header(std::span<const std::byte> bytes, std::string_view where) {
  const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
  // The identifier is checked last: one known writer omits it, but the more useful message is that its files declare no stream.
  flatbuffers::Verifier verifier(data, bytes.size(), 64, 1'000'000, true);
  if (!verifier.VerifySizePrefixedBuffer<aedat4::IoHeader>(nullptr)) {
    throw Error(std::string(where) + ": its header does not decode; expected an AEDAT4 IOHE header");
  }
  const auto* header = flatbuffers::GetSizePrefixedRoot<aedat4::IoHeader>(data);
  if (header->compression() < 0 || header->compression() > static_cast<int>(Compression::zstd_high)) {
    throw Error(std::string(where) + ": compression " + std::to_string(header->compression()) + " is not known; expected 0 to 4");
  }
  RecordingHeader result;
  result.compression = static_cast<Compression>(header->compression());
  result.table_position = header->data_table_position();
  if (header->info_node() != nullptr && header->info_node()->size() > 0) {
    result.streams = streams_in({header->info_node()->c_str(), header->info_node()->size()}, where);
  }
  if (result.streams.empty()) {
    throw Error(std::string(where) + ": declares no stream; expected at least one under outInfo in its header");
  }
  if (bytes.size() < 12 || std::memcmp(data + 8, "IOHE", 4) != 0) {
    throw Error(std::string(where) + ": its header lacks the identifier IOHE; expected an AEDAT4 header");
  }
  return result;
}

const Stream* RecordingHeader::declared(std::int32_t id) const {
  const auto found = std::find_if(streams.begin(), streams.end(), [id](const Stream& stream) { return stream.id == id; });
  return found == streams.end() ? nullptr : &*found;
}

HeaderImage header_image(Compression compression, std::span<const Stream> streams) {
  flatbuffers::FlatBufferBuilder builder;
  builder.ForceDefaults(true);  // otherwise -1 is omitted, and the position cannot be written later
  const auto xml = builder.CreateString(xml_of(compression, {streams.begin(), streams.end()}));
  aedat4::FinishSizePrefixedIoHeaderBuffer(builder, aedat4::CreateIoHeader(builder, static_cast<int>(compression), -1, xml));
  const std::uint8_t* data = builder.GetBufferPointer();
  const auto* table = flatbuffers::GetSizePrefixedRoot<flatbuffers::Table>(data);
  const std::uint8_t* position = table->GetAddressOf(aedat4::IoHeader::VT_DATA_TABLE_POSITION);
  return {.bytes = std::string(reinterpret_cast<const char*>(data), builder.GetSize()),
          .table_position = static_cast<std::size_t>(position - data)};
}

}  // namespace tactile::events
