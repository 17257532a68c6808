#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "tactile/model/definition/lenet_layers.hpp"

namespace tactile {

/// A parameter and its values, row by row with the last size running fastest.
struct Parameter {
  ParameterShape shape;
  std::vector<float> values;

  friend bool operator==(const Parameter&, const Parameter&) = default;
};

using Weights = std::vector<Parameter>;

/// Writes the weights as a safetensors file: the header's length as 8 bytes, least first; a JSON header that gives each
/// parameter's "dtype" (F32), "shape" and "data_offsets", and `metadata` where there is any; then the values as float32, least
/// byte first. Whole or not at all.
/// Source: https://github.com/huggingface/safetensors, "Format".
void write_weights(const std::filesystem::path& file, const Weights& weights,
                   const std::map<std::string, std::string>& metadata = {});

/// Reads such a file, which must hold exactly `expected`, in the order of `expected`.
/// @throws Error  if a parameter is missing, too many, of another shape or type, or a value is NaN or infinite
Weights read_weights(const std::filesystem::path& file, const std::vector<ParameterShape>& expected);

/// What such a file says of itself; nothing where it says nothing. @throws Error  if it is no safetensors file
std::map<std::string, std::string> read_metadata(const std::filesystem::path& file);

/// @throws Error, "<problem>; expected fc1.weight [120,9744]"  if the weights are not of these shapes
void check_shapes(const Weights& weights, const std::vector<ParameterShape>& shapes, const std::string& problem);

/// @throws Error, naming `where`, the parameter and the place in it  if a value is NaN or infinite: "w: fc1.weight[3,7] is nan;
/// ..."
void check_finite(const Weights& weights, const std::string& where);

}  // namespace tactile
