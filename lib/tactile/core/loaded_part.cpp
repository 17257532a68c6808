#include "tactile/core/loaded_part.hpp"

#include <dlfcn.h>
#include <fmt/core.h>

#include <filesystem>
#include <string>
#include <system_error>

#include "tactile/core/error.hpp"

namespace tactile {

void* load_part(const char* file, const char* symbol) {
  std::error_code failed;
  const std::filesystem::path path = std::filesystem::read_symlink("/proc/self/exe", failed).parent_path() / file;
  // Other parts and libraries look for symbols of these libraries, as for the threads of OpenBLAS.
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
