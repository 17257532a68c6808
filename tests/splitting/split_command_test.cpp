#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "splitting/long_recording.hpp"
#include "support/events_in_file.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"

namespace tactile::splitting {
namespace {
namespace fs = std::filesystem;

TEST(Probe, Make) {
  const char* to = std::getenv("PROBE");
  ASSERT_TRUE(to);
  fs::create_directories(to);
  const std::string preset = std::getenv("PRESET") ? std::getenv("PRESET") : "quick";
  const std::string extra = std::getenv("EXTRA") ? std::getenv("EXTRA") : "--objects fan,usb-hub --runs 3";
  auto r = test::run_tactile("simulate sim --preset " + preset + " " + extra, to);
  ASSERT_EQ(r.exit_code, 0) << r.err;
  const double q = std::getenv("QUIET") ? std::atof(std::getenv("QUIET")) : 4.0;
  auto made =
      test::join_runs(find_runs(fs::path(to) / "sim"), fs::path(to) / "long" / "session" / "01", microseconds{(long)(1e6 * q)});
  for (std::size_t i = 0; i < made.run_begins.size(); ++i)
    printf("run %zu: %.3f to %.3f\n", i, 1e-6 * (double)(us_of(made.run_begins[i]) - 1000000000000),
           1e-6 * (double)(us_of(made.run_ends[i]) - 1000000000000));
  for (auto& t : made.touches)
    printf("%s %.3f %.3f\n", t.touch == Touch::press ? "press" : "slip", 1e-6 * (double)(us_of(t.start) - 1000000000000),
           1e-6 * (double)(us_of(t.end) - 1000000000000));
}
}  // namespace
}  // namespace tactile::splitting
