#include "tactile/events/output_file.hpp"

#include <string>
#include <system_error>

#include "tactile/core/error.hpp"

namespace tactile::events {
namespace fs = std::filesystem;

void check_target(const fs::path& target, const fs::path& input, bool replace) {
  std::error_code failed;
  if (fs::equivalent(target, input, failed)) {
    throw Error(target.string() + ": the output is the input, " + input.string() +
                "; expected another file, the input is never replaced");
  }
  const fs::file_status status = fs::symlink_status(target, failed);
  if (!fs::exists(status)) return;
  if (fs::is_directory(target, failed)) throw Error(target.string() + ": the output is a folder; expected the name of a file");
  if (!replace) throw Error(target.string() + ": the output exists already; expected a new name, or --force to replace it");
}

}  // namespace tactile::events
