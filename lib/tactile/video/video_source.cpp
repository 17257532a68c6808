#include "tactile/video/video_source.hpp"

#include "tactile/video/load_opencv.hpp"

namespace tactile::video {

std::unique_ptr<VideoSource> open_video_source(const std::string& source) { return opencv_part().open_video_source(source); }

}  // namespace tactile::video
