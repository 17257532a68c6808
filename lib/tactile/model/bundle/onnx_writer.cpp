#include "tactile/model/bundle/onnx_writer.hpp"

#include <bit>

#include "tactile/core/version.hpp"
#include "tactile/model/bundle/onnx_model.hpp"

namespace tactile::model {
namespace {

static_assert(std::endian::native == std::endian::little, "raw_data holds values least byte first");

void describe(onnx::ValueInfoProto& value, const std::string& name, const std::string& what, const OnnxWriter::Sizes& sizes) {
  value.set_name(name);
  value.set_doc_string(what);
  onnx::TypeProto::Tensor& type = *value.mutable_type()->mutable_tensor_type();
  type.set_elem_type(onnx::TensorProto::FLOAT);
  for (const std::int64_t size : sizes) {
    onnx::TensorShapeProto::Dimension& dimension = *type.mutable_shape()->add_dim();
    size == OnnxWriter::any ? dimension.set_dim_param("n") : dimension.set_dim_value(size);
  }
}

template <class Value>
void fill(onnx::TensorProto& tensor, const std::string& name, const OnnxWriter::Sizes& sizes, const std::vector<Value>& values) {
  tensor.set_name(name);
  for (const std::int64_t size : sizes) tensor.add_dims(size);
  tensor.set_raw_data(values.data(), values.size() * sizeof(Value));
}

}  // namespace

OnnxWriter::OnnxWriter(const std::string& graph, const std::string& about, const std::map<std::string, std::string>& metadata)
    : graph_(*model_.mutable_graph()) {
  model_.set_ir_version(onnx_ir_version);
  model_.add_opset_import()->set_version(onnx_opset);  // of the standard operators, whose domain has no name
  model_.set_producer_name("tactile");
  model_.set_producer_version(std::string(version()));
  model_.set_doc_string(about);
  for (const auto& [key, value] : metadata) {
    onnx::StringStringEntryProto& entry = *model_.add_metadata_props();
    entry.set_key(key);
    entry.set_value(value);
  }
  graph_.set_name(graph);
}

void OnnxWriter::add_input(const std::string& name, const std::string& what, const Sizes& sizes) {
  describe(*graph_.add_input(), name, what, sizes);
}

void OnnxWriter::add_output(const std::string& name, const std::string& what, const Sizes& sizes) {
  describe(*graph_.add_output(), name, what, sizes);
}

void OnnxWriter::add_tensor(const std::string& name, const Sizes& sizes, const std::vector<float>& values) {
  onnx::TensorProto& tensor = *graph_.add_initializer();
  tensor.set_data_type(onnx::TensorProto::FLOAT);
  fill(tensor, name, sizes, values);
}

void OnnxWriter::add_tensor(const std::string& name, const std::vector<std::int64_t>& values) {
  onnx::TensorProto& tensor = *graph_.add_initializer();
  tensor.set_data_type(onnx::TensorProto::INT64);
  fill(tensor, name, {static_cast<std::int64_t>(values.size())}, values);
}

void OnnxWriter::add_tensors(const Weights& weights) {
  for (const Parameter& parameter : weights) add_tensor(parameter.shape.name, parameter.shape.sizes, parameter.values);
}

onnx::NodeProto& OnnxWriter::add(const std::string& op, const std::string& name, const std::vector<std::string>& inputs) {
  onnx::NodeProto& node = *graph_.add_node();
  node.set_op_type(op);
  node.set_name(name);
  for (const std::string& input : inputs) node.add_input(input);
  node.add_output(name);
  return node;
}

void set(onnx::NodeProto& node, const std::string& attribute, std::int64_t value) {
  onnx::AttributeProto& added = *node.add_attribute();
  added.set_name(attribute);
  added.set_type(onnx::AttributeProto::INT);
  added.set_i(value);
}

void set(onnx::NodeProto& node, const std::string& attribute, const std::vector<std::int64_t>& values) {
  onnx::AttributeProto& added = *node.add_attribute();
  added.set_name(attribute);
  added.set_type(onnx::AttributeProto::INTS);
  for (const std::int64_t value : values) added.add_ints(value);
}

}  // namespace tactile::model
