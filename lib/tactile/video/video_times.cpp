#include "tactile/video/video_times.hpp"

#include <fmt/core.h>

#include <optional>
#include <string>

#include "tactile/core/csv_table.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/table_file.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::video {

std::vector<VideoTime> read_video_times(const std::filesystem::path& path) {
  // A power cut may leave gigabytes of zeros after the last row.
  TableFile table(path, {.name = "the times of a video's frames", .header = "index,pts_us", .ends_in_any_bytes = true});
  const std::string& file = table.file();
  const auto column_of = [&](std::string_view name) {
    if (const std::optional<std::size_t> column = table.find(name)) return *column;
    throw Error(fmt::format("{}: no column '{}'; expected a header row with index,pts_us", file, name));
  };
  const std::size_t index_column = column_of("index"), time_column = column_of("pts_us");
  std::vector<VideoTime> times;
  while (table.next() && table.is_ended()) {
    if (table.is_blank()) continue;
    if (!table.is_whole()) table.refuse_row();
    const std::int64_t index = table.whole_number_at(index_column);
    if (index != static_cast<std::int64_t>(times.size()))
      throw Error(fmt::format("{}: row {} has index {}; expected {}", file, table.number(), index, times.size()));
    const VideoTime t{microseconds{table.whole_number_at(time_column)}};
    if (!times.empty() && t <= times.back()) {
      throw Error(fmt::format("{}: row {} has pts_us {}; expected more than {}, the time of the frame before", file,
                              table.number(), us_of(t), us_of(times.back())));
    }
    times.push_back(t);
  }
  return times;
}

void write_video_times(const std::filesystem::path& file, std::span<const VideoTime> times) {
  CsvTable table("index,pts_us");
  for (std::size_t i = 0; i < times.size(); ++i) table.add_row(i, us_of(times[i]));
  write_whole(file, table.text());
}

}  // namespace tactile::video
