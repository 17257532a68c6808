#pragma once

#include <onnx/onnx_pb.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tactile/model/bundle/weights.hpp"

namespace tactile::model {

/// An ONNX model while its nodes are added. The name of a node is also that of its output.
class OnnxWriter {
 public:
  using Sizes = std::vector<std::int64_t>;
  static constexpr std::int64_t any = -1;  ///< a size that the caller of the network chooses

  /// @param graph     the name of the graph
  /// @param about     what the model is, for display
  /// @param metadata  becomes the model's metadata_props
  OnnxWriter(const std::string& graph, const std::string& about, const std::map<std::string, std::string>& metadata);

  /// float32 values. @param what  they are, in words
  void add_input(const std::string& name, const std::string& what, const Sizes& sizes);
  void add_output(const std::string& name, const std::string& what, const Sizes& sizes);

  void add_tensor(const std::string& name, const Sizes& sizes, const std::vector<float>& values);
  void add_tensor(const std::string& name, const std::vector<std::int64_t>& values);
  void add_tensors(const Weights& weights);

  /// @param op  an operator of ONNX
  onnx::NodeProto& add(const std::string& op, const std::string& name, const std::vector<std::string>& inputs);

  std::string bytes() const { return model_.SerializeAsString(); }

 private:
  onnx::ModelProto model_;
  onnx::GraphProto& graph_;
};

void set(onnx::NodeProto& node, const std::string& attribute, std::int64_t value);
void set(onnx::NodeProto& node, const std::string& attribute, const std::vector<std::int64_t>& values);

}  // namespace tactile::model
