#include "tactile/core/loaded_part.hpp"

#include <dlfcn.h>
#include <fmt/core.h>

#include <filesystem>
#include <string>
#include <system_error>

#include "tactile/core/error.hpp"
#include "tactile/core/machine.hpp"

namespace tactile {

namespace {

/// The folder of the running program.
std::filesystem::path program_folder(const char* file) {
  std::error_code failed;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", failed);
  if (failed)
    throw Error(fmt::format("{}: /proc/self/exe cannot be read ({}); expected it to name the folder of the program", file,
                            failed.message()));
  if (program.string().ends_with(" (deleted)"))
    throw Error(fmt::format("{}: the program was replaced since it began; start the command again", file));
  return program.parent_path();
}

}  // namespace

void* load_part(const char* file, const char* symbol, std::size_t room) {
  const std::filesystem::path path = program_folder(file) / file;
  if (!has_room_for(room))
    throw Error(
        fmt::format("{}: cannot be loaded within the limit on memory; it needs {} MB more (ulimit -v)", file, room >> 20));
  // RTLD_GLOBAL: `model::prepare_blas` looks for OpenBLAS among all symbols.
  void* const part = ::dlopen(path.c_str(), RTLD_NOW | RTLD_GLOBAL);
  void* const object = part == nullptr ? nullptr : ::dlsym(part, symbol);
  if (object == nullptr) {
    const char* const reason = ::dlerror();
    throw Error(
        fmt::format("{}: cannot be loaded ({}); expected this part of tactile in the folder of the program, and enough memory",
                    path.string(), reason == nullptr ? "it is another file" : reason));
  }
  return object;
}

}  // namespace tactile
