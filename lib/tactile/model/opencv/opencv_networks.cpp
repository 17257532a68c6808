#include "tactile/model/opencv/opencv_networks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/dnn.hpp>

#include "tactile/core/error.hpp"
#include "tactile/model/inference/own_outputs.hpp"

namespace tactile::model {
namespace {

class OwnOnOpenCv final : public OwnNetwork {
 public:
  OwnOnOpenCv(const std::string& onnx, NetworkPorts ports) : ports_(std::move(ports)) {
    for (const std::vector<NetworkPort>* all : {&ports_.inputs, &ports_.outputs}) {
      for (const NetworkPort& port : *all) {
        if (port.shape.size() < 2)
          throw Error(fmt::format("{} has the shape [{}]; expected two sizes or more, as OpenCV's dnn needs them", port.name,
                                  fmt::join(port.shape, ", ")));
      }
    }
    cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
    cv::setNumThreads(1);  // a thread for each stream is enough, and small networks run faster so
    try {
      net_ = cv::dnn::readNetFromONNX(onnx.data(), onnx.size());
    } catch (const cv::Exception& e) {
      throw Error(
          fmt::format("OpenCV's dnn cannot read it ({}); expected an ONNX file whose operators it knows", line_of(e.err)));
    }
    for (const NetworkPort& port : ports_.outputs) outputs_.push_back(port.name);
  }

  void run(std::span<const std::vector<float>> inputs, std::span<std::vector<float>> outputs) override {
    std::vector<cv::Mat> found;
    try {
      for (std::size_t i = 0; i < inputs.size(); ++i) {
        const std::vector<int> sizes(ports_.inputs[i].shape.begin(), ports_.inputs[i].shape.end());
        net_.setInput(cv::Mat(sizes, CV_32F, const_cast<float*>(inputs[i].data())), ports_.inputs[i].name);
      }
      net_.forward(found, outputs_);
    } catch (const cv::Exception& e) {
      throw Error(
          fmt::format("OpenCV's dnn cannot run it ({}); expected inputs and outputs as its description says", line_of(e.err)));
    }
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      const std::vector<std::int64_t> sizes(found[i].size.p, found[i].size.p + found[i].dims);
      check_output(ports_.outputs[i], sizes);
      if (found[i].type() != CV_32F)
        throw Error(fmt::format("its output {} has other values; expected float32", ports_.outputs[i].name));
      const cv::Mat whole = found[i].isContinuous() ? found[i] : found[i].clone();
      std::copy_n(whole.ptr<float>(), outputs[i].size(), outputs[i].begin());
    }
  }

 private:
  NetworkPorts ports_;
  cv::dnn::Net net_;
  std::vector<cv::String> outputs_;
};

std::unique_ptr<OwnNetwork> open(const std::string& onnx, const NetworkPorts& ports) {
  return std::make_unique<OwnOnOpenCv>(onnx, ports);
}

}  // namespace
}  // namespace tactile::model

extern "C" const tactile::model::OpenCvNetworks tactile_opencv_networks{tactile::model::open};
