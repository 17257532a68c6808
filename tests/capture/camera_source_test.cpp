#include "tactile/capture/camera_source.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "support/temporary_folder.hpp"
#include "tactile/capture/libcaer_camera.hpp"
#include "tactile/capture/readout_mode.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::capture {
namespace {

std::string refusal_of(const std::string& text, const CameraSourceOptions& options = {}) {
  try {
    open_camera_source(text, options);
  } catch (const Error& error) {
    return error.what();
  }
  return "opened";
}

CameraSourceOptions at_speed(double speed) {
  CameraSourceOptions options;
  options.speed = speed;
  return options;
}

CameraSourceOptions in_mode(const std::string& mode) {
  CameraSourceOptions options;
  options.readout_mode = mode;
  return options;
}

TEST(OpenCameraSource, ExplainsWhatASourceLooksLikeWhereNoneIsGiven) {
  for (const char* text : {"", "cam", "simulator", "http://127.0.0.1:7777", "cameras", "sim.water-bottle"}) {
    const std::string refusal = refusal_of(text);
    EXPECT_NE(refusal.find("'" + std::string(text) + "' is no source"), std::string::npos) << refusal;
    EXPECT_NE(refusal.find("camera[:SERIAL]"), std::string::npos) << refusal;
  }
  for (const char* text : {"127.0.0.1:7777", "tcp:127.0.0.1:7777", "//127.0.0.1:7777"}) {
    EXPECT_NE(refusal_of(text).find("is no source; expected tcp://127.0.0.1:7777"), std::string::npos) << refusal_of(text);
  }
  for (const char* text : {"sim:", "camera:", "file:"}) {
    EXPECT_NE(refusal_of(text).find("nothing follows the colon"), std::string::npos) << text;
  }
}

TEST(OpenCameraSource, ExplainsThatAPathTakesAPrefix) {
  const test::TemporaryFolder folder;
  const std::string file = (folder / "a.aedat4").string();
  write_whole(file, "");
  EXPECT_NE(refusal_of(file).find("expected file:" + file), std::string::npos);
}

TEST(OpenCameraSource, NamesWhatIsNotThere) {
  const test::TemporaryFolder folder;
  const std::string missing = "file:" + (folder / "none.aedat4").string();
  EXPECT_NE(refusal_of(missing).find("none.aedat4"), std::string::npos);
  write_whole(folder / "empty.aedat4", "");
  EXPECT_NE(refusal_of("file:" + (folder / "empty.aedat4").string()).find("empty.aedat4"), std::string::npos);
  const std::string object = refusal_of("sim:cup");
  EXPECT_NE(object.find("cup"), std::string::npos);
  EXPECT_NE(object.find("water-bottle"), std::string::npos) << "the ones there are: " << object;
  EXPECT_NE(refusal_of("unix:" + (folder / "no-socket").string()).find("no-socket"), std::string::npos);
}

TEST(OpenCameraSource, TakesNoSpeedOutOfRange) {
  EXPECT_NE(refusal_of("sim", at_speed(-1)).find("speed"), std::string::npos);
  EXPECT_NE(refusal_of("sim", at_speed(std::numeric_limits<double>::quiet_NaN())).find("speed"), std::string::npos);
}

TEST(OpenCameraSource, SetsAReadOutModeOnlyOnACamera) {
  EXPECT_NE(refusal_of("sim", in_mode("variable-5000")).find("cannot be set"), std::string::npos);
  const std::string refusal = refusal_of("camera", in_mode("fast"));
  EXPECT_NE(refusal.find("'fast'"), std::string::npos);
  EXPECT_NE(refusal.find("variable-15000"), std::string::npos);
}

TEST(OpenCameraSource, ChoosesAStreamOnlyOfAFile) {
  CameraSourceOptions options;
  options.stream = "1";
  for (const char* text : {"sim", "sim:fan", "tcp://127.0.0.1:1", "unix:/none", "camera"}) {
    const std::string refusal = refusal_of(text, options);
    EXPECT_NE(refusal.find(std::string(text) + ": has no choice of streams"), std::string::npos) << refusal;
  }
}

TEST(OpenCameraSource, ExplainsWhyThereIsNoCameraAndWhatElseThereIs) {
  const std::string refusal = refusal_of("camera:NOTHERE");
  EXPECT_EQ(refusal.find("camera:NOTHERE: "), 0U) << refusal;
  if (is_built_with_libcaer()) {
    EXPECT_NE(refusal.find("DVXplorer"), std::string::npos) << refusal;
  } else {
    EXPECT_NE(refusal.find("no libcaer"), std::string::npos) << refusal;
    EXPECT_NE(refusal.find("scripts/dv-bridge"), std::string::npos) << refusal;
  }
}

TEST(ReadoutModes, AreThoseOfTheVendor) {
  EXPECT_EQ(readout_modes().size(), 11U);
  EXPECT_NO_THROW(readout_mode(default_readout_mode));
  // What a constant mode waits and reads makes up its period.
  for (const auto& [name, period_us] :
       {std::pair{"constant-100", 10'000U}, {"constant-200", 5'000U}, {"constant-500", 2'000U}, {"constant-1000", 1'000U}}) {
    const ReadoutMode& mode = readout_mode(name);
    EXPECT_TRUE(mode.fixed_read_time);
    EXPECT_EQ(mode.wait_us + mode.read_cycles / 50, period_us) << name;
  }
  EXPECT_FALSE(readout_mode("variable-2000").fixed_read_time);
  EXPECT_EQ(readout_mode("lossy-10000").read_cycles, 5000U);
}

}  // namespace
}  // namespace tactile::capture
