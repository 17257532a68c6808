#include "tactile/events/repair_run.hpp"

#include <array>
#include <cstdint>
#include <fstream>
#include <string_view>
#include <vector>

#include "tactile/core/error.hpp"
#include "tactile/core/run_files.hpp"
#include "tactile/core/version.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::events {
namespace fs = std::filesystem;
namespace {

/// The end of the last row before the first zero byte [B].
std::uint64_t end_of_whole_rows(const fs::path& csv) {
  std::ifstream in(csv, std::ios::binary);
  std::array<char, 65'536> bytes{};
  std::uint64_t begin = 0, rows_end = 0;
  while (in.read(bytes.data(), bytes.size()), in.gcount() > 0) {
    const std::string_view piece(bytes.data(), static_cast<std::size_t>(in.gcount()));
    const std::size_t zero = piece.find('\0');
    const std::size_t last = piece.substr(0, zero).rfind('\n');
    if (last != std::string_view::npos) rows_end = begin + last + 1;
    if (zero != std::string_view::npos) return rows_end;
    begin += piece.size();
  }
  return begin;
}

}  // namespace

RepairSummary repair_run(const RunFolder& in, const fs::path& out, unsigned threads, const ProgressCallback& progress) {
  const fs::path place = fs::absolute(out).lexically_normal();
  const fs::path folder = place.has_filename() ? place : place.parent_path();
  const std::string run = folder.filename().string(), object = folder.parent_path().filename().string();
  if (!is_run_id(run) || !is_object_name(object)) {
    throw Error(out.string() + ": is not a run's folder; expected DATA/<object>/<run>, such as " +
                (in.folder.parent_path() / "02").string());
  }
  if (fs::exists(fs::symlink_status(folder))) throw Error(out.string() + ": exists already; expected a new run's folder");
  RunInfo info = read_run_info(in);

  WholeFile whole(folder, IfThere::refuse);
  fs::create_directory(whole.path());
  const RunFolder made{whole.path(), object, run};
  RepairSummary summary = repair_recording(in.events(), made.events(), false, threads, progress);
  std::vector<fs::path> files{made.events()};
  for (const auto& [from, to] : {std::pair(in.robot(), made.robot()), std::pair(in.video(), made.video()),
                                 std::pair(in.video_times(), made.video_times()), std::pair(in.truth(), made.truth())}) {
    if (!fs::exists(from)) continue;
    std::error_code failed;
    fs::copy_file(from, to, failed);
    if (failed)
      throw Error(from.string() + ": cannot be copied (" + failed.message() + "); expected a readable file and a disk with room");
    if (to.extension() == ".csv") {
      const std::uint64_t size = fs::file_size(to), rows_end = end_of_whole_rows(to);
      if (rows_end < size) summary.log_bytes_lost[to.filename().string()] = size - rows_end;
      fs::resize_file(to, rows_end);
    }
    sync_to_disk(to);
    files.push_back(to);
  }

  info.object = object;
  info.run = run;
  info.complete = true;
  info.extra.erase("simulation");  // the simulator replaces only what it made itself
  info.extra["files"] = files_json(files);
  info.extra["repaired"] = {{"from", in.name()},
                            {"packets_kept", summary.packets_kept()},
                            {"packets_lost", summary.packets_lost()},
                            {"packets_damaged", summary.packets_damaged},
                            {"bytes_lost", summary.bytes_lost()},
                            {"log_bytes_lost", summary.log_bytes_lost},
                            {"version", version()}};
  write_run_info(made, info);
  whole.commit();
  return summary;
}

}  // namespace tactile::events
