#include "tactile/model/bundle/weights.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <string>
#include <string_view>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/json_text.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::model {
namespace {

static_assert(std::endian::native == std::endian::little, "values and the header's length are written as they lie in memory");

constexpr std::size_t length_bytes = 8;
constexpr std::size_t longest_header = std::size_t{16} << 20;

std::string sizes_in_words(const std::vector<std::int64_t>& sizes) { return nlohmann::json(sizes).dump(); }

/// The length of the header, from the first bytes. @throws Error  if the file ends inside the header
std::size_t header_length(const std::string& text, std::uint64_t bytes, const std::string& where) {
  std::uint64_t length = 0;
  if (text.size() < length_bytes) throw Error(where + ": cut off; expected a safetensors file");
  std::memcpy(&length, text.data(), length_bytes);
  if (length > longest_header || length > bytes - length_bytes)
    throw Error(where + ": its header is " + std::to_string(length) + " bytes long; expected a safetensors file");
  return static_cast<std::size_t>(length);
}

nlohmann::json parsed_header(std::string_view text, const std::string& where) {
  try {
    return nlohmann::json::parse(text.begin(), text.end());
  } catch (const nlohmann::json::exception&) {
    throw Error(where + ": its header is not JSON; expected a safetensors file");
  }
}

}  // namespace

void write_weights(const std::filesystem::path& file, const Weights& weights,
                   const std::map<std::string, std::string>& metadata) {
  nlohmann::json header = nlohmann::json::object();
  if (!metadata.empty()) header["__metadata__"] = metadata;
  std::uint64_t offset = 0;
  for (const Parameter& parameter : weights) {
    const std::uint64_t end = offset + parameter.values.size() * sizeof(float);
    header[parameter.shape.name] = {{"dtype", "F32"}, {"shape", parameter.shape.sizes}, {"data_offsets", {offset, end}}};
    offset = end;
  }
  std::string header_text = json_text(header);
  header_text.append((length_bytes - header_text.size() % length_bytes) % length_bytes, ' ');  // to align the values
  const std::uint64_t length = header_text.size();
  std::string text(length_bytes, '\0');
  std::memcpy(text.data(), &length, length_bytes);
  text += header_text;
  for (const Parameter& parameter : weights) {
    text.append(reinterpret_cast<const char*>(parameter.values.data()), parameter.values.size() * sizeof(float));
  }
  write_whole(file, text);
}

Weights read_weights(const std::filesystem::path& file, const std::vector<ParameterShape>& expected) {
  std::size_t value_bytes = 0;
  for (const ParameterShape& shape : expected) value_bytes += shape.count() * sizeof(float);
  const std::string where = file.string();
  const std::string text = read_text(file, length_bytes + longest_header + value_bytes);
  const std::size_t length = header_length(text, text.size(), where);
  const std::size_t values_at = length_bytes + length;
  if (text.size() - values_at != value_bytes) {
    throw Error(where + ": " + std::to_string(text.size() - values_at) + " bytes of values; expected " +
                std::to_string(value_bytes));
  }
  const nlohmann::json header = parsed_header(std::string_view(text).substr(length_bytes, length), where);
  if (!header.is_object() || header.size() - header.count("__metadata__") != expected.size()) {
    throw Error(where + ": its header does not list " + std::to_string(expected.size()) +
                " parameters; expected those of the network");
  }
  Weights weights;
  for (const ParameterShape& shape : expected) {
    const auto entry = member<nlohmann::json>(header, shape.name, where);
    const std::string parameter = where + ": " + shape.name;
    const auto sizes = member<std::vector<std::int64_t>>(entry, "shape", parameter);
    const auto offsets = member<std::vector<std::uint64_t>>(entry, "data_offsets", parameter);
    if (const auto type = member<std::string>(entry, "dtype", parameter); type != "F32")
      throw Error(fmt::format("{}: its values are of type '{}'; expected F32", parameter, type));
    if (sizes != shape.sizes)
      throw Error(parameter + ": of sizes " + sizes_in_words(sizes) + "; expected " + sizes_in_words(shape.sizes));
    const std::size_t bytes = shape.count() * sizeof(float);
    if (offsets.size() != 2 || offsets[0] > value_bytes || offsets[1] > value_bytes || offsets[1] < offsets[0] ||
        offsets[1] - offsets[0] != bytes) {
      throw Error(parameter + ": its values lie outside the file; expected " + std::to_string(bytes) + " bytes of them");
    }
    Parameter read{shape, std::vector<float>(shape.count())};
    std::memcpy(read.values.data(), text.data() + values_at + offsets[0], bytes);
    weights.push_back(std::move(read));
  }
  check_finite(weights, where);
  return weights;
}

std::map<std::string, std::string> read_metadata(const std::filesystem::path& file) {
  const std::string where = file.string();
  if (!std::filesystem::is_regular_file(file)) throw Error(where + ": is missing; expected a safetensors file");
  std::ifstream in(file, std::ios::binary);
  std::string text(length_bytes, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(std::max<std::streamsize>(in.gcount(), 0)));
  const std::size_t length = header_length(text, std::filesystem::file_size(file), where);
  text.resize(length);
  in.read(text.data(), static_cast<std::streamsize>(length));
  if (!in) throw Error(where + ": reading it failed half-way; expected a readable file");
  const nlohmann::json header = parsed_header(text, where);
  if (!header.is_object() || !header.contains("__metadata__")) return {};
  return member<std::map<std::string, std::string>>(header, "__metadata__", where);
}

void check_shapes(const Weights& weights, const std::vector<ParameterShape>& shapes, const std::string& problem) {
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    if (weights.size() != shapes.size() || weights[i].shape != shapes[i] || weights[i].values.size() != shapes[i].count())
      throw Error(problem + "; expected " + shapes[i].name + " " + sizes_in_words(shapes[i].sizes));
  }
}

void check_finite(const Weights& weights, const std::string& where, float largest) {
  for (const Parameter& parameter : weights) {
    const auto bad = std::find_if(parameter.values.begin(), parameter.values.end(),
                                  [=](float value) { return !(std::abs(value) <= largest); });
    if (bad == parameter.values.end()) continue;
    std::vector<std::int64_t> place(parameter.shape.sizes.size());
    std::int64_t left = bad - parameter.values.begin();
    for (std::size_t i = place.size(); i-- > 0; left /= parameter.shape.sizes[i]) place[i] = left % parameter.shape.sizes[i];
    throw Error(fmt::format("{}: {}{} is {:g}; expected finite weights{}", where, parameter.shape.name, sizes_in_words(place),
                            *bad, largest < std::numeric_limits<float>::max() ? fmt::format(" of at most {:g}", largest) : ""));
  }
}

}  // namespace tactile::model
