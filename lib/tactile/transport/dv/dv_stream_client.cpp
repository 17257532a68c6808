#include "tactile/transport/dv/dv_stream_client.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "tactile/core/error.hpp"
#include "tactile/transport/connection.hpp"
#include "tactile/transport/deadline.hpp"
#include "tactile/transport/dv/dv_stream_parser.hpp"

namespace tactile::transport {

using std::chrono::milliseconds;

namespace {

constexpr std::size_t small_room = std::size_t{16} << 10;  // [B]: smaller packets are received several at once
constexpr milliseconds longest_reading{1};                 // of available bytes, with a patience of 0

std::uint64_t unusable_packets(const DvStreamParser& parser) {
  const DvStreamProblems& problems = parser.problems();
  return problems.broken_packets + problems.mismatched_packets + problems.foreign_packets;
}

}  // namespace

struct DvStreamClient::State {
  State(const NetworkAddress& address, milliseconds connecting)
      : connection(address, connecting), parser(address.text()), patience(connecting) {}

  Connection connection;
  DvStreamParser parser;
  milliseconds patience;  ///< for the header, and for the rest of a packet that has begun
  SteadyClock::time_point heard = SteadyClock::now();
  std::uint64_t bytes = 0;
  std::array<std::byte, small_room> ahead{};  ///< bytes received before they were needed
  std::span<std::byte> unread;                ///< part of `ahead`
  bool filled_ahead = false;                  ///< the last read filled `ahead`: more bytes may be available
  bool more_came = false;                     ///< after the last packet

  void read_header();
  Received receive(microseconds waiting);
  std::optional<std::size_t> fill(std::span<std::byte> room, microseconds waiting);
};

/// As `Connection::receive`, but reads ahead if `room` is small, such as for a packet's header. This saves system calls.
std::optional<std::size_t> DvStreamClient::State::fill(std::span<std::byte> room, microseconds waiting) {
  if (unread.empty()) {
    const bool takes_more = room.size() < small_room;
    const auto got = connection.receive(takes_more ? std::span(ahead) : room, waiting);
    if (got) bytes += *got;
    filled_ahead = false;
    if (!takes_more || !got) return got;
    unread = std::span(ahead).first(*got);
    filled_ahead = *got == ahead.size();
  }
  const std::size_t count = std::min(unread.size(), room.size());
  std::memcpy(room.data(), unread.data(), count);
  unread = unread.subspan(count);
  return count;
}

void DvStreamClient::State::read_header() {
  const SteadyClock::time_point deadline = deadline_after(patience);
  while (!parser.has_header()) {
    const auto got = fill(parser.room(), left_until(deadline));
    if (!got) parser.end();
    if (*got == 0) {
      throw Error(connection.address().text() + ": sent no complete header within " + seconds_text(patience) +
                  "; expected a stream of DV 1.6 or newer, dv-processing or tactile serve");
    }
    parser.received(*got);
  }
}

DvStreamClient::Received DvStreamClient::State::receive(microseconds waiting) {
  const SteadyClock::time_point deadline = deadline_after(waiting);
  const std::uint64_t unusable = unusable_packets(parser);
  for (;;) {
    const auto got = fill(parser.room(), left_until(deadline));
    if (!got) {
      parser.end();
      return Received::closed;
    }
    const SteadyClock::time_point now = SteadyClock::now();
    if (*got == 0) {
      if (parser.is_between_packets() || now - heard < patience) return Received::nothing;
      throw Error(connection.address().text() + ": stopped inside a packet, nothing arrived for " + seconds_text(patience) +
                  "; expected the rest of it");
    }
    heard = now;
    if (parser.received(*got)) {
      more_came = !unread.empty() || !parser.is_between_packets() || filled_ahead;
      return Received::packet;
    }
    // `nothing` means that no packet is available. Therefore a packet that has begun is read as far as its bytes are available.
    // Unusable packets end the loop: there may be any number of them.
    const bool is_at_rest = unread.empty() && parser.is_between_packets();
    if (now >= deadline + longest_reading && (is_at_rest || unusable_packets(parser) > unusable)) return Received::nothing;
  }
}

DvStreamClient::DvStreamClient(const NetworkAddress& address, milliseconds patience)
    : state_(std::make_unique<State>(address, patience)) {
  state_->read_header();
}
DvStreamClient::~DvStreamClient() = default;
DvStreamClient::DvStreamClient(DvStreamClient&&) noexcept = default;
DvStreamClient& DvStreamClient::operator=(DvStreamClient&&) noexcept = default;

const NetworkAddress& DvStreamClient::address() const { return state_->connection.address(); }
const events::Stream& DvStreamClient::stream() const { return state_->parser.stream(); }
events::Compression DvStreamClient::compression() const { return state_->parser.compression(); }
DvStreamClient::Received DvStreamClient::receive(microseconds patience) { return state_->receive(patience); }

std::span<events::Event> DvStreamClient::events() { return state_->parser.events(); }
std::span<const events::ImuSample> DvStreamClient::imu() const { return state_->parser.imu(); }
std::span<const events::Trigger> DvStreamClient::triggers() const { return state_->parser.triggers(); }
const std::optional<events::Frame>& DvStreamClient::frame() const { return state_->parser.frame(); }
const DvStreamProblems& DvStreamClient::problems() const { return state_->parser.problems(); }
std::optional<HostTime> DvStreamClient::arrived() const { return state_->connection.arrived(); }
bool DvStreamClient::more_came() const { return state_->more_came; }
bool DvStreamClient::reports_arrivals() const { return state_->connection.reports_arrivals(); }
std::uint64_t DvStreamClient::bytes_received() const { return state_->bytes; }

}  // namespace tactile::transport
