#pragma once

#include <filesystem>
#include <string>

#include "command.hpp"
#include "tactile/conversion/bag_import.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::cli {

/// The events and the IMU of a bag as a recording in the folder for temporary files, removed when this goes.
class BagRecording {
 public:
  /// Logs what the recording lacks. @throws Error  as `import_bag`
  BagRecording(const std::string& bag, conversion::BagImportOptions options, const CommonArguments& common);

  std::filesystem::path file() const { return summary_.run.events(); }
  const conversion::BagImportSummary& summary() const { return summary_; }

 private:
  PartFolder folder_;
  conversion::BagImportSummary summary_;
};

/// Logs what is missing in a run or recording made from a bag.
void warn_about_import(const std::string& bag, const conversion::BagImportSummary& summary);

}  // namespace tactile::cli
