#pragma once

#include <nlohmann/json.hpp>

namespace CLI {
class App;
}  // namespace CLI

namespace tactile::cli {

/// The options of a command as a file for --config has them, {"th": 40, "held-out": ["fan"]}: those given on the command line or
/// in a file, and the others whose default is a value. An option whose default depends on something else, such as "the
/// preset's", is left out unless it was given. So are --json, --quiet, --verbose, --force and --resume, which change no result.
/// @param command  after its options were read
nlohmann::json effective_settings(CLI::App& command);

}  // namespace tactile::cli
