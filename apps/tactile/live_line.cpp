#include "live_line.hpp"

#include <spdlog/spdlog.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdio>

namespace tactile::cli {

LiveLine::LiveLine(bool wanted) : draws_(wanted && isatty(STDERR_FILENO) != 0) {}

void LiveLine::erase() {
  if (visible_) std::fputs("\r\033[K", stderr);
  visible_ = false;
}

void LiveLine::draw(const std::string& text) {
  if (!draws_) return;
  const std::scoped_lock lock(guard_);
  winsize window{};
  const std::size_t columns = ioctl(STDERR_FILENO, TIOCGWINSZ, &window) == 0 && window.ws_col > 0 ? window.ws_col : 80;
  std::fprintf(stderr, "\r\033[K%s", text.substr(0, columns - 1).c_str());
  visible_ = true;
}

void LiveLine::clear() {
  const std::scoped_lock lock(guard_);
  erase();
}

void LiveLine::warn(const std::string& text) {
  const std::scoped_lock lock(guard_);
  erase();
  spdlog::warn("{}", text);
}

void LiveLine::inform(const std::string& text) {
  const std::scoped_lock lock(guard_);
  erase();
  spdlog::info("{}", text);
}

}  // namespace tactile::cli
