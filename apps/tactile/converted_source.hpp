#pragma once

#include <filesystem>
#include <string>

#include "command.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/event_csv.hpp"
#include "tactile/splitting/split_source.hpp"

namespace tactile::cli {

/// A recording of another format as AEDAT4, or a bag as a run, in a hidden folder next to DATA; removed when this goes.
class ConvertedSource {
 public:
  /// Logs what the run lacks, if it is made from a bag. @throws Error  as `convert_recording` and `import_bag`
  ConvertedSource(const std::string& in, const std::filesystem::path& data, const CommonArguments& common);

  const splitting::SplitSource& source() const { return source_; }

 private:
  PartFolder folder_;
  splitting::SplitSource source_;
};

/// Whether it is no AEDAT4 recording or run folder. @throws Error  if its format is unknown
bool needs_conversion(const std::filesystem::path& in);

/// Logs that a CSV's times were corrected.
void warn_of_overflows(const std::string& in, const events::TimeOverflows& overflows);

/// Logs what could not be read, and is in no run.
void warn_of_losses(const std::string& recording, const events::RecordingProblems& problems);

}  // namespace tactile::cli
