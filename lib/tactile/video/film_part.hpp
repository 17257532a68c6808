#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace tactile::video {

/// The frames of a film, in the order in which they are shown.
struct FilmFrames {
  std::vector<std::int64_t> times_us;  ///< by the container, from the first one, ascending
  std::vector<bool> is_key;            ///< coded by itself
  std::vector<std::int64_t> stamps;    ///< the same times as the file has them, in its own unit
  bool is_in_order = true;             ///< the file has them in the order in which they are shown

  /// The last key frame not after this one; 0 if there is none.
  std::size_t key_before(std::size_t frame) const;
};

/// Reads a film of any length without decoding it. @throws Error  if it holds no video, or a frame has no time of its own
FilmFrames film_frames(const std::filesystem::path& film);

/// Frames of a film, [begin, end).
struct FilmPart {
  std::size_t begin = 0, end = 0;
};

/// Copies a part of a film to a fragmented MP4 as it is coded, without loss. It begins at the key frame at `part.begin` or before
/// it, as a decoder needs. If the file's order differs from that in which the frames are shown, it also ends before a key frame.
/// Times begin at 0.
/// @param frames  of this film
/// @param to      a new file
/// @return        the frames that it has
/// @throws Error  if the part has no frame, or MP4 does not take this coding
FilmPart copy_film_part(const std::filesystem::path& film, const FilmFrames& frames, FilmPart part,
                        const std::filesystem::path& to);

}  // namespace tactile::video
