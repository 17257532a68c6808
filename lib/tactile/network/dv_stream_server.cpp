#include "tactile/network/dv_stream_server.hpp"

#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <asio.hpp>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <limits>
#include <list>
#include <mutex>
#include <thread>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/events/packet_compression.hpp"
#include "tactile/events/packet_contents.hpp"
#include "tactile/events/recording_header.hpp"
#include "tactile/network/deadline.hpp"
#include "tactile/network/dv_stream_client.hpp"

namespace tactile {
namespace {

using std::chrono::milliseconds;
using StreamProtocol = asio::generic::stream_protocol;

constexpr std::size_t packet_header_size = 8;
constexpr std::size_t packets_at_once = 16;  ///< handed to the system in one call

/// What goes to every client, made once.
struct SharedBytes {
  explicit SharedBytes(std::size_t length) : bytes(new std::byte[length]), size(length) {}
  std::unique_ptr<std::byte[]> bytes;  // left unset: every byte is written by who makes it
  std::size_t size;                    ///< [B]
};
using SharedPacket = std::shared_ptr<const SharedBytes>;

/// One client. Its socket is touched by the server's thread alone; the rest is guarded by the server's mutex.
struct Client {
  explicit Client(StreamProtocol::socket connected, std::string called) : socket(std::move(connected)), name(std::move(called)) {}

  StreamProtocol::socket socket;
  std::string name;
  std::deque<SharedPacket> queue;
  std::size_t queued = 0;   ///< [B] in the queue, not yet with the system
  std::size_t sent = 0;     ///< [B] of the queue's first packet that are
  bool writing = false;     ///< a write is under way
  bool gone = false;        ///< left or dropped
  std::uint64_t taken = 0;  ///< [B] altogether
  std::byte ignored{};      ///< where a byte would go that it must not send
};

std::string refusal(const NetworkAddress& address, const std::string& why) {
  return address.text() + ": cannot listen there (" + why + ")";
}

}  // namespace

struct DvStreamServer::State {
  NetworkAddress address;
  Stream stream;
  DvStreamServerOptions options;
  SharedPacket header;
  PacketBuffer content, stored;
  PacketCompressor compressor;

  asio::io_context context;
  asio::basic_socket_acceptor<StreamProtocol> listener{context};
  asio::steady_timer accept_again{context};
  bool owns_path = false;
  std::thread thread;

  mutable std::mutex mutex;
  std::condition_variable moved;  ///< a client took something, or is gone
  std::list<std::shared_ptr<Client>> clients;
  std::uint64_t joined = 0, dropped = 0;

  ~State();
  void check_stream() const;
  void listen();
  void run();
  void accept();
  void take(StreamProtocol::socket socket, const StreamProtocol::endpoint& peer);
  void watch(const std::shared_ptr<Client>& client);
  void write(const std::shared_ptr<Client>& client);
  void wrote(const std::shared_ptr<Client>& client, std::size_t bytes);
  void forget(const std::shared_ptr<Client>& client, const std::string& why, bool is_drop);
  void drop_soon(const std::shared_ptr<Client>& client, std::string why);
  void log(const std::string& text) const;

  void check_type(StreamType type) const;
  void check_size(std::size_t payload) const;
  void check_content(std::size_t size) const;
  bool has_clients() const;
  std::shared_ptr<SharedBytes> packet_of(std::size_t payload) const;
  void send_content(std::size_t size);
  void share(SharedPacket packet);
};

void DvStreamServer::State::check_stream() const {
  check_readable_by_vendor(stream, address.text());
  if (options.client_queue < 1) throw Error(address.text() + ": a client's queue of 0 bytes; expected more");
  if (options.clients < 1) throw Error(address.text() + ": no client allowed; expected 1 at least");
}

void DvStreamServer::State::listen() {
  std::vector<StreamProtocol::endpoint> places;
  if (address.kind == NetworkAddress::Kind::unix_socket) {
    places.emplace_back(asio::local::stream_protocol::endpoint(address.path.string()));
  } else {
    std::error_code error;
    asio::ip::tcp::resolver resolver(context);
    const auto flags = asio::ip::resolver_base::passive | asio::ip::resolver_base::numeric_service;
    for (const auto& found : resolver.resolve(address.host, std::to_string(address.port), flags, error)) {
      places.emplace_back(found.endpoint());
    }
    if (error) throw Error(refusal(address, error.message()) + "; expected a name or an address of this machine");
  }
  std::error_code error;
  for (const StreamProtocol::endpoint& place : places) {
    const bool is_unix = place.protocol().family() == AF_UNIX;
    listener.close(error);
    listener.open(place.protocol(), error);
    // A server that ended leaves its port blocked for a minute otherwise.
    if (!error && !is_unix) listener.set_option(asio::socket_base::reuse_address(true), error);
    if (!error) listener.bind(place, error);
    if (!error) owns_path = is_unix;
    if (!error) listener.listen(asio::socket_base::max_listen_connections, error);
    if (error) continue;
    if (!is_unix) {
      asio::ip::tcp::endpoint taken;
      auto size = static_cast<socklen_t>(taken.capacity());
      ::getsockname(listener.native_handle(), taken.data(), &size);
      address.port = taken.port();
    }
    return;
  }
  const bool is_unix = address.kind == NetworkAddress::Kind::unix_socket;
  const bool exists = is_unix && error == asio::error::address_in_use;
  throw Error(refusal(address, exists ? "the path exists already" : error.message()) +
              (exists                                 ? "; expected a path where there is nothing"
               : is_unix                              ? "; expected a path in a folder that is there and may be written to"
               : error == asio::error::address_in_use ? "; expected a free port of this machine"
               : error == asio::error::access_denied  ? "; expected a port that this user may take, such as one from 1024 on"
                                                      : "; expected an address of this machine, such as 127.0.0.1"));
}

/// Every handler runs here. What one of them throws, for want of memory, ends only what it was about.
void DvStreamServer::State::run() {
  for (;;) {
    try {
      context.run();
      return;
    } catch (const std::exception& e) {
      log(address.text() + ": " + e.what());
    }
  }
}

DvStreamServer::State::~State() {
  context.stop();
  if (thread.joinable()) thread.join();
  if (owns_path) ::unlink(address.path.c_str());
}

void DvStreamServer::State::log(const std::string& text) const {
  if (options.log) options.log(text);
}

void DvStreamServer::State::accept() {
  auto socket = std::make_shared<StreamProtocol::socket>(context);
  auto peer = std::make_shared<StreamProtocol::endpoint>();
  listener.async_accept(*socket, *peer, [this, socket, peer](const std::error_code& error) {
    if (error == asio::error::operation_aborted) return;
    if (!error) {
      accept();
      take(std::move(*socket), *peer);
      return;
    }
    // No more files may be opened, or the client has gone again: a moment later it may work.
    accept_again.expires_after(milliseconds(100));
    accept_again.async_wait([this](const std::error_code& cancelled) {
      if (!cancelled) accept();
    });
  });
}

void DvStreamServer::State::take(StreamProtocol::socket socket, const StreamProtocol::endpoint& peer) {
  std::string name;
  if (peer.protocol().family() == AF_UNIX) {
    name = fmt::format("client {} of {}", joined + 1, address.text());
  } else {
    asio::ip::tcp::endpoint endpoint;
    std::memcpy(endpoint.data(), peer.data(), std::min(peer.size(), endpoint.capacity()));
    const bool is_ipv6 = endpoint.address().is_v6();
    name = fmt::format("{}{}{}:{}", is_ipv6 ? "[" : "", endpoint.address().to_string(), is_ipv6 ? "]" : "", endpoint.port());
    const int yes = 1;
    ::setsockopt(socket.native_handle(), IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
  }
  const auto client = std::make_shared<Client>(std::move(socket), name);
  {
    const std::lock_guard lock(mutex);
    if (clients.size() < options.clients) {
      client->queue.push_back(header);
      client->queued = header->size;
      client->writing = true;
      clients.push_back(client);
      ++joined;
    } else {
      client->gone = true;
    }
  }
  if (client->gone) {
    log(fmt::format("{} turned away: {} clients are here, which is the most", name, options.clients));
    return;
  }
  log(name + " joined");
  watch(client);
  write(client);
}

/// Notices a client that closes. It is not to send anything.
void DvStreamServer::State::watch(const std::shared_ptr<Client>& client) {
  client->socket.async_read_some(asio::buffer(&client->ignored, 1), [this, client](const std::error_code& error, std::size_t) {
    if (error == asio::error::operation_aborted) return;
    if (!error) {
      forget(client, "it sent something, which a client of a DV stream never does", true);
    } else if (error == asio::error::eof || error == asio::error::connection_reset) {
      forget(client, "", false);
    } else {
      forget(client, error.message(), false);
    }
  });
}

/// Hands the front of the queue to the system; goes on by itself until the queue is empty. `writing` is set already.
void DvStreamServer::State::write(const std::shared_ptr<Client>& client) {
  std::vector<asio::const_buffer> buffers;
  std::vector<SharedPacket> held;  // until the write is done, whatever becomes of the queue
  {
    const std::lock_guard lock(mutex);
    if (client->gone) return;
    std::size_t skipped = client->sent;
    for (const SharedPacket& packet : client->queue) {
      if (buffers.size() == packets_at_once) break;
      buffers.emplace_back(packet->bytes.get() + skipped, packet->size - skipped);
      held.push_back(packet);
      skipped = 0;
    }
    client->writing = !buffers.empty();
  }
  if (buffers.empty()) return;
  client->socket.async_write_some(buffers,
                                  [this, client, held = std::move(held)](const std::error_code& error, std::size_t bytes) {
                                    if (error == asio::error::operation_aborted) return;
                                    if (error) {
                                      forget(client, "", false);
                                      return;
                                    }
                                    wrote(client, bytes);
                                    write(client);
                                  });
}

void DvStreamServer::State::wrote(const std::shared_ptr<Client>& client, std::size_t bytes) {
  {
    const std::lock_guard lock(mutex);
    if (client->gone) return;
    client->taken += bytes;
    client->queued -= bytes;
    client->sent += bytes;
    while (!client->queue.empty() && client->sent >= client->queue.front()->size) {
      client->sent -= client->queue.front()->size;
      client->queue.pop_front();
    }
  }
  moved.notify_all();
}

/// On the server's thread: the client is gone, for its own reasons or ours.
void DvStreamServer::State::forget(const std::shared_ptr<Client>& client, const std::string& why, bool is_drop) {
  {
    const std::lock_guard lock(mutex);
    if (client->gone) return;
    client->gone = true;
    if (is_drop) ++dropped;
    clients.remove(client);
    client->queue.clear();
    client->queued = 0;
  }
  std::error_code ignored;
  client->socket.close(ignored);
  moved.notify_all();
  log(client->name + (is_drop ? " dropped: " + why : why.empty() ? " left" : " left: " + why));
}

/// From any thread, with the mutex held: nothing more is queued for the client, and the server's thread closes it.
void DvStreamServer::State::drop_soon(const std::shared_ptr<Client>& client, std::string why) {
  client->gone = true;
  ++dropped;
  client->queue.clear();
  client->queued = 0;
  asio::post(context, [this, client, why = std::move(why)] {
    std::error_code ignored;
    client->socket.close(ignored);
    log(client->name + " dropped: " + why);
  });
}

void DvStreamServer::State::check_type(StreamType type) const {
  if (stream.type != type) {
    throw Error(fmt::format("{}: carries {}, not {}", address.text(), name_of(stream.type), name_of(type)));
  }
}

void DvStreamServer::State::check_size(std::size_t payload) const {
  if (payload > dv_packet_limit) {
    throw Error(fmt::format("{}: a packet of {} bytes; expected at most {}", address.text(), payload, dv_packet_limit));
  }
}

/// Before it is compressed, a packet may have as much as its reader lets it decompress to.
void DvStreamServer::State::check_content(std::size_t size) const {
  if (options.compression == Compression::none) check_size(size);
  if (size > packet_limit - 4096) {
    throw Error(fmt::format("{}: a packet of {} bytes; expected at most {}", address.text(), size, packet_limit - 4096));
  }
}

bool DvStreamServer::State::has_clients() const {
  const std::lock_guard lock(mutex);
  return !clients.empty();
}

/// A packet without its payload yet.
std::shared_ptr<SharedBytes> DvStreamServer::State::packet_of(std::size_t payload) const {
  check_size(payload);
  auto packet = std::make_shared<SharedBytes>(packet_header_size + payload);
  const auto size = static_cast<std::uint32_t>(payload);
  std::memcpy(packet->bytes.get(), &stream.id, sizeof stream.id);
  std::memcpy(packet->bytes.get() + sizeof stream.id, &size, sizeof size);
  return packet;
}

/// Sends the `size` bytes at the front of `content`.
void DvStreamServer::State::send_content(std::size_t size) {
  PacketBuffer* payload = &content;
  if (options.compression != Compression::none) {
    size = compressor.compress(options.compression, {content.data(), size}, stored, 0);
    payload = &stored;
  }
  auto packet = packet_of(size);
  std::memcpy(packet->bytes.get() + packet_header_size, payload->data(), size);
  share(std::move(packet));
}

void DvStreamServer::State::share(SharedPacket packet) {
  bool any_dropped = false;
  {
    const std::lock_guard lock(mutex);
    for (auto at = clients.begin(); at != clients.end();) {
      const std::shared_ptr<Client> client = *at;
      if (client->queued > 0 && client->queued + packet->size > options.client_queue) {
        drop_soon(client, fmt::format("{:.1f} MB behind", 1e-6 * static_cast<double>(client->queued)));
        at = clients.erase(at);
        any_dropped = true;
        continue;
      }
      ++at;
      client->queue.push_back(packet);
      client->queued += packet->size;
      if (!std::exchange(client->writing, true)) asio::post(context, [this, client] { write(client); });
    }
  }
  if (any_dropped) moved.notify_all();
}

DvStreamServer::DvStreamServer(const NetworkAddress& address, Stream stream, DvStreamServerOptions options)
    : state_(std::make_unique<State>()) {
  state_->address = address;
  state_->stream = std::move(stream);
  state_->options = std::move(options);
  state_->check_stream();
  const HeaderImage image = header_image(state_->options.compression, std::span(&state_->stream, 1));
  auto header = std::make_shared<SharedBytes>(image.bytes.size());
  std::memcpy(header->bytes.get(), image.bytes.data(), image.bytes.size());
  state_->header = std::move(header);
  state_->listen();
  state_->accept();
  state_->thread = std::thread([state = state_.get()] { state->run(); });
}
DvStreamServer::~DvStreamServer() = default;

const NetworkAddress& DvStreamServer::address() const { return state_->address; }

std::size_t DvStreamServer::clients() const {
  const std::lock_guard lock(state_->mutex);
  return state_->clients.size();
}

std::uint64_t DvStreamServer::joined_clients() const {
  const std::lock_guard lock(state_->mutex);
  return state_->joined;
}

std::uint64_t DvStreamServer::dropped_clients() const {
  const std::lock_guard lock(state_->mutex);
  return state_->dropped;
}

void DvStreamServer::send(std::span<const Event> events) {
  state_->check_type(StreamType::events);
  const std::size_t size = event_packet_head + events.size_bytes();
  state_->check_content(size);
  if (events.empty() || !state_->has_clients()) return;
  const auto put = [&](std::byte* place) {
    write_event_packet_head(place, events.size());
    std::memcpy(place + event_packet_head, events.data(), events.size_bytes());
  };
  if (state_->options.compression == Compression::none) {
    auto packet = state_->packet_of(size);
    put(packet->bytes.get() + packet_header_size);
    state_->share(std::move(packet));
    return;
  }
  state_->content.grow(size, 0);
  put(state_->content.data());
  state_->send_content(size);
}

void DvStreamServer::send(std::span<const ImuSample> samples) {
  state_->check_type(StreamType::imu);
  state_->check_content(samples.size_bytes());
  if (samples.empty() || !state_->has_clients()) return;
  state_->send_content(encode_imu(samples, state_->content, 0));
}

void DvStreamServer::send(std::span<const Trigger> triggers) {
  state_->check_type(StreamType::triggers);
  state_->check_content(triggers.size_bytes());
  if (triggers.empty() || !state_->has_clients()) return;
  state_->send_content(encode_triggers(triggers, state_->content, 0));
}

void DvStreamServer::send(const Frame& frame) {
  state_->check_type(StreamType::frames);
  const auto side = [](std::int16_t length) { return static_cast<std::size_t>(std::max<int>(length, 0)); };
  const std::size_t pixels = side(frame.width) * side(frame.height);
  if (frame.pixels.size() != pixels * bytes_per_pixel(frame.format)) {
    throw Error(fmt::format("{}: a frame of {} x {} in format {} with {} bytes; expected as many as its pixels take",
                            state_->address.text(), frame.width, frame.height, frame.format, frame.pixels.size()));
  }
  state_->check_content(frame.pixels.size());
  if (pixels == 0 || !state_->has_clients()) return;
  state_->send_content(encode_frame(frame, state_->content, 0));
}

bool DvStreamServer::wait_for_room(milliseconds patience, const std::function<bool()>& stop) {
  struct Lagging {
    std::shared_ptr<Client> client;
    std::uint64_t taken = 0;
    SteadyClock::time_point since;
  };
  std::vector<Lagging> watched;
  std::unique_lock lock(state_->mutex);
  for (;;) {
    const SteadyClock::time_point now = SteadyClock::now();
    bool any = false;
    for (auto at = state_->clients.begin(); at != state_->clients.end();) {
      const std::shared_ptr<Client> client = *at++;
      if (client->queued <= state_->options.client_queue / 2) continue;
      const auto known =
          std::find_if(watched.begin(), watched.end(), [&](const Lagging& lagging) { return lagging.client == client; });
      if (known == watched.end()) {
        watched.push_back({.client = client, .taken = client->taken, .since = now});
      } else if (known->taken != client->taken) {
        known->taken = client->taken;
        known->since = now;
      } else if (now - known->since >= patience) {
        state_->drop_soon(client, "it took nothing for " + seconds_text(patience));
        state_->clients.remove(client);
        continue;
      }
      any = true;
    }
    if (!any) return true;
    lock.unlock();
    if (stop && stop()) return false;
    lock.lock();
    state_->moved.wait_for(lock, std::min(patience, milliseconds(50)));
  }
}

void DvStreamServer::drain(milliseconds patience) {
  std::unique_lock lock(state_->mutex);
  const auto is_empty = [&] {
    return std::all_of(state_->clients.begin(), state_->clients.end(), [](const auto& client) { return client->queued == 0; });
  };
  state_->moved.wait_until(lock, deadline_after(patience), is_empty);
}

}  // namespace tactile
