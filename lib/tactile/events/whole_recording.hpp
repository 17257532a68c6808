#pragma once

#include <filesystem>

namespace tactile {

/// A recording that appears under its name only once it is whole: written beside it under a hidden temporary name that ends in
/// .aedat4 as the target does, then synced and renamed. One that is never committed is removed.
class WholeRecording {
 public:
  /// The input is never written over, through whatever path or hard link the target reaches it.
  /// @throws Error  if `target` is the input, or exists already and is not to be replaced, or its folder cannot be made
  WholeRecording(std::filesystem::path target, const std::filesystem::path& input, bool replace);
  ~WholeRecording();
  WholeRecording(const WholeRecording&) = delete;
  WholeRecording& operator=(const WholeRecording&) = delete;

  const std::filesystem::path& path() const { return temporary_; }  ///< where to write until `commit`
  void commit();                                                    ///< @throws Error if syncing or renaming fails

 private:
  std::filesystem::path target_;
  std::filesystem::path temporary_;
  bool committed_ = false;
};

/// @throws Error  if writing to `target` would write over `input`, or over anything else although `replace` is false
void check_target(const std::filesystem::path& target, const std::filesystem::path& input, bool replace);

}  // namespace tactile
