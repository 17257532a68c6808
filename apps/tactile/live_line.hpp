#pragma once

#include <mutex>
#include <string>

namespace tactile::cli {

/// One line on stderr that is drawn again and again, if that is a terminal. Log lines do not collide with it. Several threads may
/// use it.
class LiveLine {
 public:
  explicit LiveLine(bool wanted);  ///< nothing is drawn without a terminal
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

}  // namespace tactile::cli
