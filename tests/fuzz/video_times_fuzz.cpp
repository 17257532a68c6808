#include "abort_unless.hpp"
#include "bytes_as_file.hpp"
#include "tactile/core/error.hpp"
#include "tactile/video/video_times.hpp"

/// For any input, the times that are read ascend, or there is an Error.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactile;
  const test::BytesAsFile file(data, size);
  try {
    const std::vector<VideoTime> times = video::read_video_times(file.path());
    for (std::size_t i = 1; i < times.size(); ++i) test::abort_unless(times[i] > times[i - 1]);
  } catch (const Error&) {
  }
  return 0;
}
