#include "tactile/robot/repeated_messages.hpp"

#include <fmt/core.h>

#include "tactile/core/host_clock.hpp"

namespace tactile::robot {
namespace {

constexpr std::size_t most_kept = 64;
constexpr std::chrono::seconds quiet_for{10};

}  // namespace

void RepeatedMessages::hear(const std::string& text) {
  Heard& heard = heard_[text];
  heard.last = host_now();
  if (++heard.times == 1) report_(text);
  if (heard_.size() > most_kept) forget_all();
}

void RepeatedMessages::forget_old() {
  if (!heard_.empty()) forget_before(host_now() - quiet_for);
}

void RepeatedMessages::forget_all() { forget_before(HostTime::max()); }

void RepeatedMessages::forget_before(HostTime moment) {
  std::erase_if(heard_, [&](const auto& one) {
    const auto& [text, heard] = one;
    if (heard.last >= moment) return false;
    if (heard.times > 1) report_(fmt::format("{} (came {} times)", text, heard.times));
    return true;
  });
}

}  // namespace tactile::robot
