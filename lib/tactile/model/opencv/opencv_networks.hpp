#pragma once

#include <memory>
#include <string>

#include "tactile/model/inference/own_network.hpp"

namespace tactile::model {

/// What `tactile-opencv.so` provides for networks in ONNX files, beside what the stage `video` loads it for.
struct OpenCvNetworks {
  /// @param onnx     the contents of the file
  /// @throws Error   if OpenCV's dnn cannot read it, or a shape has fewer than two sizes
  std::unique_ptr<OwnNetwork> (*open)(const std::string& onnx, const NetworkPorts& ports);
};

}  // namespace tactile::model
