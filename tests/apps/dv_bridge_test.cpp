#include <gtest/gtest.h>

#include <filesystem>

#include "support/paths.hpp"
#include "support/run_command.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::cli {
namespace {

/// In the vendor's place: a package that knows two read-out modes, and says when a camera is looked for.
constexpr const char* vendor = R"(
class io:
    class camera:
        class DVXplorer:
            class ReadoutFPS:
                __members__ = {"CONSTANT_LOSSY_2000": 1, "VARIABLE_5000": 2}
        def discover():
            print("looks for cameras")
            return []
)";

TEST(DvBridge, ChecksTheReadoutModeAheadOfTheCamera) {
  const test::TemporaryFolder folder;
  write_whole(folder / "dv_processing.py", vendor);
  const std::string command =
      "PYTHONPATH=. python3 '" + std::string(test::data_folder) + "/../../scripts/dv-bridge' --readout-mode ";
  const test::CommandResult wrong = test::run_shell(command + "fast", folder.path());
  EXPECT_EQ(wrong.exit_code, 1);
  EXPECT_EQ(wrong.err, "dv-bridge: --readout-mode fast: there is no such mode; expected lossy-2000, variable-5000\n");
  EXPECT_EQ(wrong.out, "");
  const test::CommandResult right = test::run_shell(command + "variable-5000", folder.path());
  EXPECT_EQ(right.exit_code, 1);
  EXPECT_EQ(right.out, "looks for cameras\n");
  EXPECT_NE(right.err.find("no camera was found"), std::string::npos) << right.err;
}

}  // namespace
}  // namespace tactile::cli
