#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tactile/core/run_folder.hpp"
#include "tactile/core/time.hpp"

namespace tactile::review {

/// The frames of a run's film as JPEG pictures in grey, 640 px wide at the most, in a nameless file that ends with its owner: a
/// film can only be decoded from its start, and its pictures do not fit into memory.
class FilmFrames {
 public:
  /// Decodes the whole film. Frames without a time, or whose time does not ascend, are left out.
  /// @param advance  called before each frame; may throw to end it
  /// @throws Error  if the film cannot be read, or has no frame with a time
  FilmFrames(const RunFolder& run, const std::function<void()>& advance);
  ~FilmFrames();

  const std::vector<VideoTime>& times() const { return times_; }  ///< ascending
  int width() const { return width_; }                            ///< [px] of the pictures
  int height() const { return height_; }

  /// A frame as JPEG. May be called from several threads. @throws Error  if it cannot be read back
  std::string jpeg(std::size_t index) const;

 private:
  struct Place {
    std::int64_t offset = 0;  ///< [B] in the file
    std::size_t size = 0;     ///< [B]
  };

  std::vector<VideoTime> times_;
  std::vector<Place> places_;
  int width_ = 0, height_ = 0;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> pictures_;
};

}  // namespace tactile::review
