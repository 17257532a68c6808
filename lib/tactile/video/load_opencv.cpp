#include "tactile/video/load_opencv.hpp"

#include "tactile/core/loaded_part.hpp"
#include "tactile/core/numbers.hpp"

namespace tactile::video {
namespace {

// The part calls functions of the program that loads it. This keeps the file that it calls in each such program.
[[gnu::used]] const auto called_by_part = &whole_number_in;

}  // namespace

const OpenCvPart& opencv_part() {
  static const auto& part =
      *static_cast<const OpenCvPart*>(load_part("tactile-opencv.so", "tactile_opencv_part", std::size_t{256} << 20));
  return part;
}

}  // namespace tactile::video
