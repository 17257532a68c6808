#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "events/made_recording.hpp"
#include "support/comes_true.hpp"
#include "support/paths.hpp"
#include "support/run_command.hpp"
#include "support/running_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile::test {

inline std::ptrdiff_t lines_in(const std::string& text) { return std::count(text.begin(), text.end(), '\n'); }

/// The command in a folder with recordings of the vendor.
class RecordCommand : public ::testing::Test {
 protected:
  static constexpr events::SensorSize size{640, 480};

  RecordCommand() { std::filesystem::create_directory_symlink(std::string(data_folder) + "/aedat4", folder / "recordings"); }
  CommandResult run(const std::string& arguments) const { return run_tactile(arguments, folder.path()); }
  RunFolder run_folder(const std::string& object, const std::string& number) const {
    return {folder / "data" / object / number, object, number};
  }
  nlohmann::json run_json(const std::string& object, const std::string& number) const {
    return read_json(run_folder(object, number).info());
  }
  /// Twenty seconds of events and an hour of one a second, so that a replay at its own pace outlives every test.
  std::vector<events::Event> make_long_recording() const {
    std::vector<events::Event> events = steady_events(400'000, 1'000'000, 50, size);
    for (const events::Event& later : steady_events(3'600, 22'000'000, 1'000'000, size)) events.push_back(later);
    events::RecordingWriter writer(folder / "long.aedat4", {events::event_stream_declaration(size, "DVXplorer_DXM00001")});
    writer.write_events(0, events);
    writer.close();
    return events;
  }
  bool has_begun(const RunFolder& run, RunningCommand& command) const {
    return comes_true([&] {
             return (std::filesystem::exists(run.events()) && std::filesystem::file_size(run.events()) > 0) ||
                    command.has_ended();
           }) &&
           !command.has_ended();
  }

  TemporaryFolder folder;
};

}  // namespace tactile::test
