#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/splitting/device_clock.hpp"
#include "tactile/splitting/split_source.hpp"

namespace tactile::splitting {

/// A stretch of a device's clock, [begin, end) [us]; nothing: without limit.
struct DeviceSpan {
  std::optional<std::int64_t> begin{}, end{};

  bool holds(std::int64_t us) const { return (!begin || us >= *begin) && (!end || us < *end); }
};

/// The stretch of each piece, longer by `margin` and the clock's uncertainty on either side. The first piece has everything
/// before it, the last one everything after it.
std::vector<DeviceSpan> spans_of(const DeviceClock& clock, std::span<const CameraTime> cuts, microseconds margin);

/// Copies the rows of each piece of a robot log, as they are in the log, with its header. A row without a time (a lost
/// connection, a row that is cut off) goes where the row before it went.
/// @param logs  new files, one per piece
/// @return      rows of each piece
/// @throws Error  if the log cannot be read, or a file cannot be written
std::vector<std::uint64_t> cut_robot_log(const SplitSource& source, const std::optional<DeviceClock>& clock,
                                         std::span<const DeviceSpan> spans, std::span<const std::filesystem::path> logs);

/// Where a piece's film is written.
struct FilmFiles {
  std::filesystem::path film, times;
};

/// Copies the frames of each piece as they are coded, from a key frame on, and their times on the film's own clock, so that all
/// pieces share it. A piece without frames gets no file. The other columns of the film's times stay.
/// @return  frames of each piece
/// @throws Error  if the film cannot be read or copied, or has another number of frames than its times
std::vector<std::uint64_t> cut_film(const SplitSource& source, const DeviceClock& clock, std::span<const DeviceSpan> spans,
                                    std::span<const FilmFiles> files);

}  // namespace tactile::splitting
