#include "tactile/transport/dv/dv_stream_server.hpp"

#include <utility>

#include "tactile/transport/dv/dv_stream_clients.hpp"
#include "tactile/transport/dv/dv_stream_packets.hpp"

namespace tactile::transport {
namespace {

bool is_empty(const events::Frame& frame) { return frame.pixels.empty(); }
template <typename Element>
bool is_empty(std::span<const Element> elements) {
  return elements.empty();
}

}  // namespace

struct DvStreamServer::State {
  DvStreamPackets packets;
  DvStreamClients clients;

  template <typename Elements>
  void send(const Elements& elements) {
    packets.check(elements);
    if (!is_empty(elements) && clients.count() > 0) clients.send(packets.encode(elements));
  }
};

DvStreamServer::DvStreamServer(const NetworkAddress& address, events::Stream stream, DvStreamServerOptions options) {
  DvStreamPackets packets(address.text(), std::move(stream), options.compression);
  SharedPacket header = packets.header();
  state_.reset(new State{std::move(packets), {address, options, std::move(header)}});
}
DvStreamServer::~DvStreamServer() = default;

const NetworkAddress& DvStreamServer::address() const { return state_->clients.address(); }
std::size_t DvStreamServer::clients() const { return state_->clients.count(); }
std::uint64_t DvStreamServer::joined_clients() const { return state_->clients.joined(); }
std::uint64_t DvStreamServer::dropped_clients() const { return state_->clients.dropped(); }

void DvStreamServer::send(std::span<const events::Event> events) { state_->send(events); }
void DvStreamServer::send(std::span<const events::ImuSample> samples) { state_->send(samples); }
void DvStreamServer::send(std::span<const events::Trigger> triggers) { state_->send(triggers); }
void DvStreamServer::send(const events::Frame& frame) { state_->send(frame); }

bool DvStreamServer::wait_for_room(std::chrono::milliseconds patience, const std::function<bool()>& stop) {
  return state_->clients.wait_for_room(patience, stop);
}
void DvStreamServer::drain(std::chrono::milliseconds patience) { state_->clients.drain(patience); }

}  // namespace tactile::transport
