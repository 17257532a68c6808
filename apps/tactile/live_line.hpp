#pragma once

#include <mutex>
#include <string>

namespace tactile {

/// One line on stderr that is drawn over and over, where that is a terminal, and log lines that do not run into it. May be used
/// from several threads.
class LiveLine {
 public:
  explicit LiveLine(bool wanted);  ///< without a terminal nothing is ever drawn
  ~LiveLine() { clear(); }
  LiveLine(const LiveLine&) = delete;
  LiveLine& operator=(const LiveLine&) = delete;

  bool draws() const { return draws_; }
  void draw(const std::string& text);
  void clear();
  void warn(const std::string& text);
  void inform(const std::string& text);

 private:
  void erase();

  std::mutex guard_;
  bool draws_;
  bool visible_ = false;
};

}  // namespace tactile
