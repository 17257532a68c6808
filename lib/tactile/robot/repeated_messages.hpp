#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>

#include "tactile/core/time.hpp"

namespace tactile {

/// Some controllers send the same message with every package: it is told when it comes first, and counted from there on, until it
/// has been quiet for 10 s; then how often it came is told, if more than once. At most 64 different ones are kept.
class RepeatedMessages {
 public:
  using Tell = std::function<void(const std::string&)>;
  explicit RepeatedMessages(Tell tell) : tell_(std::move(tell)) {}

  void hear(const std::string& text);
  void forget_old();  ///< those that have been quiet long enough
  void forget_all();

 private:
  struct Heard {
    std::uint64_t times = 0;
    HostTime last{};
  };
  void forget_before(HostTime moment);

  Tell tell_;
  std::map<std::string, Heard> heard_;
};

}  // namespace tactile
