#include "standard_streams.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iostream>

#include "tactile/core/error.hpp"

namespace tactile::cli {
namespace {

/// @param why  errno; 0 if unknown
std::string sentence_about(int why) {
  const char* expected = "a place with room";
  if (why == EPIPE) expected = "a program that reads it to its end";
  if (why == EBADF) expected = "one that is open for writing";
  return std::string("standard output: cannot be written") +
         (why == 0 ? std::string() : " (" + std::string(std::strerror(why)) + ")") + "; expected " + expected;
}

}  // namespace

void open_missing_streams() {
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(descriptor, F_GETFD) != -1 || errno != EBADF) continue;
    // `open` returns the lowest free number: this one.
    static_cast<void>(::open("/dev/null", descriptor == STDERR_FILENO ? O_WRONLY : O_RDONLY));
  }
}

void print(std::string_view text) {
  errno = 0;
  const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0;
  if (!written) throw Error(sentence_about(errno));
}

std::string what_output_lost() {
  errno = 0;
  std::cout.flush();
  if (std::fflush(stdout) != 0) return sentence_about(errno);
  if (std::ferror(stdout) != 0 || !std::cout.good()) return sentence_about(0);
  // Some network file systems report a full disk only when a descriptor is closed. Closing a copy is enough.
  const int copy = ::dup(STDOUT_FILENO);
  return copy < 0 || ::close(copy) == 0 ? std::string() : sentence_about(errno);
}

void print_error(const std::string& sentence) noexcept { std::fprintf(stderr, "tactile: %s\n", sentence.c_str()); }

}  // namespace tactile::cli
