#pragma once

#include <chrono>
#include <optional>
#include <string>

namespace tactile::cli {

/// Lines of standard input, with a limited wait.
class InputLines {
 public:
  /// The next line, without its end; nothing if none arrives within `patience`.
  std::optional<std::string> next(std::chrono::milliseconds patience);
  /// Whether standard input has ended. What it holds after its last line end is no line.
  bool ended() const { return ended_; }

 private:
  std::optional<std::string> buffered();

  std::string text_;
  bool ended_ = false;
};

}  // namespace tactile::cli
