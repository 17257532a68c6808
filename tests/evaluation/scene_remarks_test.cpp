#include "tactile/evaluation/scene_remarks.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "support/temporary_folder.hpp"
#include "tactile/core/random.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile::evaluation {
namespace {

/// A recording of 1 s of uniform noise. @param hz  events/s of all pixels
void write_noise(const std::filesystem::path& file, double hz) {
  Random random(3);
  std::vector<events::Event> events;
  double t = 0;  // [us]
  while (t < 1e6) {
    events.push_back({camera_time(static_cast<std::int64_t>(t)), static_cast<std::int16_t>(random.below(80)),
                      static_cast<std::int16_t>(random.below(60)), 1});
    t += random.exponential() * 1e6 / hz;
  }
  events::RecordingWriter writer(file, {events::event_stream_declaration({80, 60}, "DVXplorer_TEST")});
  writer.write_events(0, events);
  writer.close();
}

TEST(SceneRemark, NamesThreeRunsAndShowsWhetherThereAreMore) {
  const test::TemporaryFolder folder;
  const auto quiet = folder / "quiet.aedat4", loud = folder / "loud.aedat4";
  write_noise(quiet, 33'000);
  write_noise(loud, 167'000);
  std::vector<WatchedRun> runs{{"fan/01", loud}, {"fan/02", quiet}, {"box/01", loud}, {"hub/01", loud}};
  model::ModelDescription description;
  EXPECT_EQ(scene_remark(description, runs, 1), "") << "the scenes of its training runs are not known";

  characterise::SceneRanges& training = description.scene.emplace();
  training.add_run(std::vector<characterise::Scene>{{29'000, 0, 0, 0, 0.0}});
  training.add_run(std::vector<characterise::Scene>{{37'000, 0, 0, 0, 0.0}});
  const std::string three = scene_remark(description, runs, 1);
  EXPECT_TRUE(three.starts_with("scene: 3 of 4 judged runs leave the training runs: fan/01 (background ")) << three;
  for (const char* name : {"), box/01 (", "), hub/01 ("}) EXPECT_NE(three.find(name), std::string::npos) << three;
  EXPECT_TRUE(three.ends_with(")")) << three;

  runs.push_back({"jar/01", loud});
  const std::string four = scene_remark(description, runs, 1);
  EXPECT_TRUE(four.starts_with("scene: 4 of 5 judged runs leave the training runs: fan/01 (background ")) << four;
  EXPECT_EQ(four.find("jar/01"), std::string::npos) << four;
  EXPECT_TRUE(four.ends_with("), ...")) << four;
}

}  // namespace
}  // namespace tactile::evaluation
