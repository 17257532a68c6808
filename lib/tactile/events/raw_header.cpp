#include "tactile/events/raw_header.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <map>

#include "tactile/core/csv.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/text.hpp"
#include "tactile/events/recording_file.hpp"

namespace tactile::events {
namespace {

constexpr std::size_t longest_raw_header = std::size_t{64} << 10;  // known ones have some hundred bytes [B]
constexpr std::int64_t most_pixels = 2048;                         // that the words can address, in each direction

using Fields = std::map<std::string, std::string>;

/// The length of the header's next line with its end; 0 if there is none: "% " and text. Events may begin with the same byte.
std::size_t line_length(std::string_view text) {
  if (!text.starts_with("% ")) return 0;
  const std::size_t end = text.find('\n');
  if (end == std::string_view::npos) return 0;
  const bool is_text = std::all_of(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(end),
                                   [](unsigned char c) { return c >= 0x20 || c == '\t' || c == '\r'; });
  return is_text ? end + 1 : 0;
}

/// Adds what a line says: "% geometry 1280x720", or "% format EVT3;height=720;width=1280".
void add_line(std::string_view line, Fields& fields) {
  line = trimmed(line.substr(1));
  const std::size_t blank = std::min(line.find(' '), line.size());
  const std::string key = lower_case(line.substr(0, blank));
  const std::vector<std::string_view> values = split_cells(trimmed(line.substr(blank)), ';');
  fields[key] = trimmed(values.front());
  for (std::size_t i = 1; i < values.size(); ++i) {
    const std::size_t equals = values[i].find('=');
    if (equals != std::string_view::npos)
      fields[lower_case(trimmed(values[i].substr(0, equals)))] = trimmed(values[i].substr(equals + 1));
  }
}

std::string value_of(const Fields& fields, const std::string& key) {
  const auto found = fields.find(key);
  return found == fields.end() ? "" : found->second;
}

RecordingEncoding encoding_of(const Fields& fields, const std::string& name) {
  std::string format = lower_case(value_of(fields, "format"));
  if (format.empty() && fields.contains("evt")) format = "evt" + value_of(fields, "evt");
  if (format == "evt2" || format == "evt2.0") return RecordingEncoding::evt2;
  if (format == "evt3" || format == "evt3.0") return RecordingEncoding::evt3;
  throw Error(fmt::format("{}: {}; expected a RAW file of EVT2 or EVT3", name,
                          format.empty() ? "its header names no encoding" : "is encoded as '" + format.substr(0, 40) + "'"));
}

std::optional<SensorSize> size_in(std::string_view width, std::string_view height, const std::string& name) {
  const auto w = whole_number_in(width), h = whole_number_in(height);
  if (!w || !h || *w < 1 || *h < 1 || *w > most_pixels || *h > most_pixels) {
    throw Error(fmt::format("{}: its header gives a sensor of '{}' x '{}' pixels; expected 1 to {} each", name,
                            width.substr(0, 20), height.substr(0, 20), most_pixels));
  }
  return SensorSize{static_cast<int>(*w), static_cast<int>(*h)};
}

/// Files before 2022 name no geometry, but the camera's plug-in or its generation.
std::optional<SensorSize> size_of_generation(const Fields& fields) {
  constexpr std::array<std::pair<std::string_view, SensorSize>, 5> known{
      {{"genx320", {320, 320}}, {"gen3", {640, 480}}, {"gen4", {1280, 720}}, {"imx636", {1280, 720}}, {"imx646", {1280, 720}}}};
  std::string text;
  for (const char* key : {"plugin_name", "sensor_name"}) text += lower_case(value_of(fields, key)) + " ";
  for (const char* key : {"generation", "sensor_generation"}) text += "gen" + lower_case(value_of(fields, key)) + " ";
  const auto* const found =
      std::find_if(known.begin(), known.end(), [&](const auto& sensor) { return text.find(sensor.first) != std::string::npos; });
  return found == known.end() ? std::nullopt : std::optional(found->second);
}

}  // namespace

std::string_view name_of(RecordingEncoding encoding) {
  constexpr std::array<std::string_view, 3> names{"AEDAT4", "EVT2", "EVT3"};
  return names.at(static_cast<std::size_t>(encoding));
}

bool is_raw(std::string_view start) { return start.starts_with("% "); }

RawHeader read_raw_header(const RecordingFile& file) {
  std::string bytes(static_cast<std::size_t>(std::min<std::uint64_t>(file.size(), longest_raw_header)), '\0');
  file.read(0, std::as_writable_bytes(std::span(bytes)));
  Fields fields;
  std::size_t at = 0;
  while (const std::size_t length = line_length(std::string_view(bytes).substr(at))) {
    const std::string_view line = trimmed(std::string_view(bytes).substr(at, length));
    at += length;
    if (line == "% end") break;
    add_line(line, fields);
  }
  if (at == longest_raw_header)
    throw Error(fmt::format("{}: its header is longer than {} bytes; expected a RAW file", file.name(), at));
  RawHeader header{.encoding = encoding_of(fields, file.name()), .size = {}, .camera = {}, .data_begin = at};
  const std::string geometry = value_of(fields, "geometry");
  if (const std::size_t cross = geometry.find('x'); cross != std::string::npos) {
    header.size = size_in(std::string_view(geometry).substr(0, cross), std::string_view(geometry).substr(cross + 1), file.name());
  } else if (fields.contains("width") && fields.contains("height")) {
    header.size = size_in(value_of(fields, "width"), value_of(fields, "height"), file.name());
  } else {
    header.size = size_of_generation(fields);
  }
  const std::string integrator = value_of(fields, "integrator_name"), serial = value_of(fields, "serial_number");
  header.camera = (integrator.empty() ? "Prophesee" : integrator) + (serial.empty() ? "" : "_" + serial);
  return header;
}

}  // namespace tactile::events
