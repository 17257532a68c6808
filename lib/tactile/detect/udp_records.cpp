#include "tactile/detect/udp_records.hpp"

#include <netdb.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <limits>

#include "tactile/core/error.hpp"
#include "tactile/core/host_clock.hpp"

namespace tactile::detect {
namespace {

class Writer {
 public:
  explicit Writer(VerdictRecord& record) : record_(record) {}

  template <class Number>
  void put(Number number) {
    static_assert(std::endian::native == std::endian::little, "records are little-endian");
    std::memcpy(record_.data() + at_, &number, sizeof number);
    at_ += sizeof number;
  }

 private:
  VerdictRecord& record_;
  std::size_t at_ = 0;
};

std::uint32_t limited(std::int64_t value) {
  return static_cast<std::uint32_t>(std::clamp<std::int64_t>(value, 0, std::numeric_limits<std::uint32_t>::max()));
}
std::uint32_t limited(std::uint64_t value) {
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(value, std::numeric_limits<std::uint32_t>::max()));
}

}  // namespace

VerdictRecord verdict_record(const ReportedTick& tick, HostTime sent) {
  VerdictRecord record{};
  Writer writer(record);
  for (const char letter : {'T', 'A', 'C', 'V'}) writer.put(letter);
  writer.put(std::uint16_t{1});
  writer.put(static_cast<std::uint16_t>(verdict_record_size));
  writer.put(std::uint64_t{tick.number});
  writer.put(std::int64_t{us_of(tick.verdict.t)});
  writer.put(std::int64_t{us_of(sent)});
  for (const float probability : tick.verdict.probabilities) writer.put(probability);
  writer.put(limited(tick.verdict.events));
  writer.put(limited(std::int64_t{(sent - tick.due.closed).count()}));
  writer.put(limited(tick.due.skipped));
  writer.put(std::uint32_t{tick.beginning});
  writer.put(static_cast<std::uint8_t>(tick.verdict.verdict));
  writer.put(static_cast<std::uint8_t>(tick.verdict.predicted));
  writer.put(static_cast<std::uint8_t>((tick.due.by_events ? 0 : 2) | (tick.incomplete ? 4 : 0) |
                                       (tick.verdict.slip_is_confirmed ? 8 : 0)));
  return record;
}

UdpRecords::UdpRecords(const transport::NetworkAddress& to) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  const int error = ::getaddrinfo(to.host.c_str(), std::to_string(to.port).c_str(), &hints, &found);
  if (error != 0) throw Error("udp " + to.host + ": no such host (" + ::gai_strerror(error) + "); expected HOST:PORT");
  for (const addrinfo* at = found; at != nullptr && socket_ < 0; at = at->ai_next) {
    socket_ = ::socket(at->ai_family, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (socket_ >= 0 && ::connect(socket_, at->ai_addr, at->ai_addrlen) != 0) {
      ::close(socket_);
      socket_ = -1;
    }
  }
  ::freeaddrinfo(found);
  if (socket_ < 0) throw Error("udp " + to.host + ": cannot send there (" + std::strerror(errno) + "); expected HOST:PORT");
}

UdpRecords::~UdpRecords() { ::close(socket_); }

bool UdpRecords::send(const ReportedTick& tick) {
  const VerdictRecord record = verdict_record(tick, host_now());
  const bool is_sent = ::send(socket_, record.data(), record.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(record.size());
  ++(is_sent ? sent_ : failed_);
  return is_sent;
}

}  // namespace tactile::detect
