#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>

#include "tactile/core/time.hpp"

namespace tactile::robot {

/// Some controllers send the same message with every package. A message is reported when it first arrives, and then counted until
/// it has not arrived for 10 s; then its count is reported if it arrived more than once. At most 64 different messages are kept.
class RepeatedMessages {
 public:
  using Report = std::function<void(const std::string&)>;
  explicit RepeatedMessages(Report report) : report_(std::move(report)) {}

  void hear(const std::string& text);
  void forget_old();  ///< those that have not arrived for long enough
  void forget_all();

 private:
  struct Heard {
    std::uint64_t times = 0;
    HostTime last{};
  };
  void forget_before(HostTime moment);

  Report report_;
  std::map<std::string, Heard> heard_;
};

}  // namespace tactile::robot
