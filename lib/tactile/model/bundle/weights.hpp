#pragma once

#include <filesystem>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "tactile/model/definition/lenet_layers.hpp"

namespace tactile::model {

/// A parameter and its values; the index of the last size changes fastest.
struct Parameter {
  ParameterShape shape;
  std::vector<float> values;

  friend bool operator==(const Parameter&, const Parameter&) = default;
};

using Weights = std::vector<Parameter>;

/// The largest magnitude of a value in a bundle. Weights of trained networks are below 100.
inline constexpr float largest_weight = 1e9F;

/// Writes the weights as a safetensors file: the header's length as 8 bytes, little-endian; a JSON header with each parameter's
/// "dtype" (F32), "shape" and "data_offsets", and the `metadata` if any; then the values as float32, little-endian. The file
/// appears only when it is complete. Source: https://github.com/huggingface/safetensors, "Format".
void write_weights(const std::filesystem::path& file, const Weights& weights,
                   const std::map<std::string, std::string>& metadata = {});

/// Reads such a file, which must have exactly the parameters `expected`, and returns them in that order.
/// @throws Error  if parameters are missing or superfluous, have another shape or type, or a value is NaN or infinite
Weights read_weights(const std::filesystem::path& file, const std::vector<ParameterShape>& expected);

/// The metadata of such a file; may be empty. @throws Error  if it is not a safetensors file
std::map<std::string, std::string> read_metadata(const std::filesystem::path& file);

/// @throws Error, "<problem>; expected fc1.weight [120,9744]"  if the weights have other shapes
void check_shapes(const Weights& weights, const std::vector<ParameterShape>& shapes, const std::string& problem);

/// @throws Error  with `where`, the parameter and the index, if a value is NaN, infinite or beyond +-`largest`:
///                "w: fc1.weight[3,7] is nan; ..."
void check_finite(const Weights& weights, const std::string& where, float largest = std::numeric_limits<float>::max());

}  // namespace tactile::model
