#include "tactile/events/simulated_recording.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "support/temporary_folder.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile::events {
namespace {

TEST(SimulatedRecording, IsKnownByItsCameraOrItsAttribute) {
  const auto knows = [](const std::string& source) {
    const Stream stream = event_stream_declaration({640, 480}, source);
    return is_simulated({&stream, 1});
  };
  EXPECT_TRUE(knows("DVXplorer_SIM00001"));
  EXPECT_TRUE(knows("DVXplorer_SIM99999"));
  for (const char* camera : {"DVXplorer_DXM00001", "DVXplorer_SIM", "DVXplorer_SIM0000A", "SIM00001", ""})
    EXPECT_FALSE(knows(camera)) << camera;
  Stream stream = event_stream_declaration({640, 480}, "camera");
  stream.info.emplace_back(simulated_attribute, "true");
  EXPECT_TRUE(is_simulated({&stream, 1}));
  stream.info.back().second = "false";
  EXPECT_FALSE(is_simulated({&stream, 1}));
}

TEST(SimulatedRecording, OfARunIsKnownByRunJsonTruthOrCamera) {
  const test::TemporaryFolder folder;
  const auto run_of = [&](const std::string& name, const std::string& camera) {
    std::filesystem::create_directories(folder / name / "01");
    const RunFolder run = run_folder_at(folder / name / "01");
    RecordingWriter writer(run.events(), {event_stream_declaration({640, 480}, camera)});
    writer.close();
    return run;
  };
  const RunFolder simulated = run_of("simulated", "DVXplorer_SIM00001"), real = run_of("real", "DVXplorer_DXM00001");
  EXPECT_TRUE(is_simulated(simulated));
  EXPECT_FALSE(is_simulated(real));
  RunInfo info{.object = "real", .run = "01", .session = {}, .simulated = false, .complete = true, .width = 640, .height = 480};
  write_run_info(simulated, info);
  EXPECT_TRUE(is_simulated(simulated)) << "its camera counts, even against run.json";
  info.simulated = true;
  write_run_info(real, info);
  EXPECT_TRUE(is_simulated(real));
  std::filesystem::remove(real.events());
  EXPECT_TRUE(is_simulated(real)) << "without its recording";
}

}  // namespace
}  // namespace tactile::events
