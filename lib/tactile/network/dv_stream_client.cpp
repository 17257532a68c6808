#include "tactile/network/dv_stream_client.hpp"

#include <algorithm>

#include "tactile/core/error.hpp"
#include "tactile/network/connection.hpp"
#include "tactile/network/deadline.hpp"
#include "tactile/network/dv_stream_parser.hpp"

namespace tactile {

using std::chrono::milliseconds;

struct DvStreamClient::State {
  State(const NetworkAddress& address, milliseconds connecting)
      : connection(address, connecting), parser(address.text()), patience(connecting) {}

  Connection connection;
  DvStreamParser parser;
  milliseconds patience;  ///< for the header, and for the rest of a packet that has begun
  SteadyClock::time_point heard = SteadyClock::now();
  std::uint64_t bytes = 0;

  void read_header();
  Received receive(milliseconds waiting);
};

void DvStreamClient::State::read_header() {
  const SteadyClock::time_point deadline = deadline_after(patience);
  while (!parser.has_header()) {
    const auto got = connection.receive(parser.room(), left_until(deadline));
    if (!got) parser.end();
    if (*got == 0) {
      throw Error(connection.address().text() + ": sent no whole header within " + seconds_text(patience) +
                  "; expected a stream of DV 1.6 or newer, dv-processing or tactile serve");
    }
    bytes += *got;
    parser.received(*got);
  }
}

DvStreamClient::Received DvStreamClient::State::receive(milliseconds waiting) {
  const SteadyClock::time_point deadline = deadline_after(waiting);
  for (;;) {
    const auto got = connection.receive(parser.room(), left_until(deadline));
    if (!got) {
      parser.end();
      return Received::closed;
    }
    const SteadyClock::time_point now = SteadyClock::now();
    if (*got == 0) {
      if (parser.is_between_packets() || now - heard < patience) return Received::nothing;
      throw Error(connection.address().text() + ": stopped inside a packet, nothing came for " + seconds_text(patience) +
                  "; expected the rest of it");
    }
    heard = now;
    bytes += *got;
    if (parser.received(*got)) return Received::packet;
    if (now >= deadline) return Received::nothing;
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
const Stream& DvStreamClient::stream() const { return state_->parser.stream(); }
Compression DvStreamClient::compression() const { return state_->parser.compression(); }
DvStreamClient::Received DvStreamClient::receive(milliseconds patience) { return state_->receive(patience); }

std::span<Event> DvStreamClient::events() { return state_->parser.events(); }
std::span<const ImuSample> DvStreamClient::imu() const { return state_->parser.imu(); }
std::span<const Trigger> DvStreamClient::triggers() const { return state_->parser.triggers(); }
const std::optional<Frame>& DvStreamClient::frame() const { return state_->parser.frame(); }
const DvStreamProblems& DvStreamClient::problems() const { return state_->parser.problems(); }
std::uint64_t DvStreamClient::bytes_received() const { return state_->bytes; }

}  // namespace tactile
