#include "tactile/video/video_times.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "tactile/core/csv.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/text.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::video {
namespace {

std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells = split_cells(line);
  for (std::string_view& cell : cells) cell = trimmed(cell);
  return cells;
}

}  // namespace

std::vector<VideoTime> read_video_times(const std::filesystem::path& path) {
  const std::string file = path.string();
  std::ifstream in(path, std::ios::binary);
  if (!in || std::filesystem::is_directory(path)) throw Error(file + ": cannot be read; expected the times of a video's frames");
  constexpr std::size_t longest_row = 4096;  // a power cut may leave gigabytes of zeros
  std::array<char, longest_row> row{};
  // The text before the newline, or before the end of the file.
  const auto read_row = [&] {
    in.getline(row.data(), row.size());
    return std::string_view(row.data(), static_cast<std::size_t>(std::max<std::streamsize>(in.gcount() - (in.eof() ? 0 : 1), 0)));
  };
  const std::vector<std::string_view> header = cells_of(read_row());
  const std::vector<std::string> names(header.begin(), header.end());
  const auto column_of = [&](std::string_view name) {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) throw Error(fmt::format("{}: no column '{}'; expected a header row with index,pts_us", file, name));
    return static_cast<std::size_t>(found - names.begin());
  };
  const std::size_t index_column = column_of("index"), time_column = column_of("pts_us");

  std::vector<VideoTime> times;
  for (std::size_t number = 2;; ++number) {
    const std::string_view text = read_row();
    if (in.fail() && !in.eof()) {
      in.clear();
      in.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
      if (!in.eof())
        throw Error(fmt::format("{}: row {} is longer than {} bytes; expected index,pts_us", file, number, longest_row - 1));
    }
    if (in.eof()) return times;
    const std::vector<std::string_view> cells = cells_of(text);
    if (cells.size() == 1 && cells[0].empty()) continue;
    if (cells.size() != names.size()) {
      throw Error(
          fmt::format("{}: row {} has {} values; expected {}, as in its header", file, number, cells.size(), names.size()));
    }
    const auto value_at = [&](std::size_t column) {
      const std::optional<std::int64_t> value = whole_number_in(cells[column]);
      if (!value)
        throw Error(fmt::format("{}: row {}, column '{}' holds '{}'; expected a whole number", file, number, names[column],
                                cells[column]));
      return *value;
    };
    const std::int64_t index = value_at(index_column);
    if (index != static_cast<std::int64_t>(times.size())) {
      throw Error(fmt::format("{}: row {} has index {}; expected {}", file, number, index, times.size()));
    }
    const VideoTime t{microseconds{value_at(time_column)}};
    if (!times.empty() && t <= times.back()) {
      throw Error(fmt::format("{}: row {} has pts_us {}; expected more than {}, the time of the frame before", file, number,
                              us_of(t), us_of(times.back())));
    }
    times.push_back(t);
  }
}

void write_video_times(const std::filesystem::path& file, std::span<const VideoTime> times) {
  std::string text = "index,pts_us\n";
  for (std::size_t i = 0; i < times.size(); ++i) text += fmt::format("{},{}\n", i, us_of(times[i]));
  write_whole(file, text);
}

}  // namespace tactile::video
