#include "converted_source.hpp"

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include "bag_recording.hpp"
#include "quantity_text.hpp"
#include "tactile/bags/bag.hpp"
#include "tactile/conversion/bag_import.hpp"
#include "tactile/conversion/convert.hpp"

namespace tactile::cli {

namespace fs = std::filesystem;

ConvertedSource::ConvertedSource(const std::string& in, const fs::path& data, const CommonArguments& common)
    : folder_(fs::absolute(data).parent_path() / "recording") {
  if (bags::is_bag(in)) {
    const auto summary = conversion::import_bag(in, folder_.path() / "bag" / "01", {}, progress_line(common));
    warn_about_import(in, summary);
    source_ = splitting::split_source_at(summary.run.folder);
  } else {
    const fs::path file = folder_.path() / fs::path(in).stem().concat(".aedat4");
    warn_of_overflows(in, conversion::convert_recording(in, file, {.threads = common.threads}, progress_line(common)).overflows);
    source_ = splitting::split_source_at(file);
  }
  source_.name = in;
  source_.origin = fs::path(in).lexically_normal().filename().string();
}

bool needs_conversion(const fs::path& in) {
  return bags::is_bag(in) ||
         (!fs::is_directory(in) && conversion::recording_format_of(in) != conversion::RecordingFormat::aedat4);
}

void warn_of_overflows(const std::string& in, const events::TimeOverflows& overflows) {
  if (overflows.count == 0) return;
  spdlog::warn(
      "{}:{}: time goes back from {} to {} us, as a counter of {} bits does when it overflows: {} {} are added from there on{}",
      in, overflows.line, us_of(overflows.before), us_of(overflows.after), overflows.bits, std::int64_t{1} << overflows.bits,
      events::name_of(overflows.unit),
      overflows.count > 1 ? fmt::format(", and after {}", counted(overflows.count - 1, "further overflow")) : "");
}

void warn_of_losses(const std::string& recording, const events::RecordingProblems& problems) {
  if (const std::uint64_t lost = problems.broken_packets + problems.mismatched_packets; lost > 0)
    spdlog::warn("{}: {} could not be read, and are in no run", recording, counted(lost, "packet"));
  if (problems.truncated_bytes > 0)
    spdlog::warn("{}: cut off, {} after the last whole packet are in no run", recording,
                 counted(problems.truncated_bytes, "byte"));
  if (problems.out_of_range_events > 0)
    spdlog::warn("{}: {} outside the sensor are in no run", recording, counted(problems.out_of_range_events, "event"));
}

}  // namespace tactile::cli
