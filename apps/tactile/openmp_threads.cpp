#include "openmp_threads.hpp"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "command.hpp"
#include "interruption.hpp"

namespace tactile::cli {
namespace {

/// This process's arguments from the kernel, separated by zeros.
std::vector<std::string> own_arguments() {
  std::vector<std::string> arguments;
  std::string argument;
  std::FILE* file = std::fopen("/proc/self/cmdline", "rb");
  if (file == nullptr) return {};
  for (int c = std::fgetc(file); c != EOF; c = std::fgetc(file)) {
    if (c != 0) {
      argument += static_cast<char>(c);
    } else {
      arguments.push_back(std::move(argument));
      argument.clear();
    }
  }
  std::fclose(file);
  return arguments;
}

}  // namespace

void let_openmp_threads_sleep() {
  if (std::getenv("OMP_WAIT_POLICY") != nullptr) return;
  ::setenv("OMP_WAIT_POLICY", "passive", 1);
  std::vector<std::string> arguments = own_arguments();
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  if (pointers.empty()) return;
  pointers.push_back(nullptr);
  hold_signals();
  stop_if_interrupted();
  ::execv("/proc/self/exe", pointers.data());
  release_signals();  // that failed: the threads spin, which is slower, but not wrong
}

}  // namespace tactile::cli
