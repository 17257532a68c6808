#include <CLI/CLI.hpp>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "abort_unless.hpp"
#include "bytes_as_file.hpp"
#include "command.hpp"
#include "option_checks.hpp"
#include "tactile/core/error.hpp"

/// For any file of --config, a command with an option of each kind runs with values in range, or there is an error.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactile;
  const test::BytesAsFile file(data, size);
  CLI::App app("", "tactile");
  double window_ms = 500;
  std::int64_t guard_us = 0;
  std::uint64_t seed = 1;
  bool mix = false;
  std::string denoise = "mean";
  std::vector<std::int64_t> th{40};
  std::vector<std::string> held_out;
  std::optional<double> speed;
  cli::Command command = cli::add_command(app, "windows", "", [&](const cli::CommonArguments& common) {
    test::abort_unless(window_ms > 0 && guard_us >= -5 && guard_us <= 5 && common.threads >= 1 && common.threads <= 1024);
  });
  command.add_option("--window-ms", window_ms).check(cli::in_range(1e-3, 1e6));
  command.add_option("--guard-us", guard_us).check(cli::in_range(-5, 5));
  command.add_option("--seed", seed).check(cli::is_seed());
  command.add_flag("--mix", mix);
  command.add_option("--denoise", denoise).check(cli::one_of({"mean", "literal", "none"}));
  command.add_option("--th", th).delimiter(',').check(cli::in_range(1, 1000));
  command.add_option("--held-out", held_out).delimiter(',');
  command.add_option("--speed", speed).check(cli::in_range(0.0, 1e6));
  const std::string path = file.path();
  const std::array<const char*, 4> arguments{"tactile", "windows", "--config", path.c_str()};
  try {
    app.parse(static_cast<int>(arguments.size()), arguments.data());
  } catch (const CLI::ParseError&) {
  } catch (const Error&) {
  }
  return 0;
}
