#include "tactile/transport/dv/dv_stream_clients.hpp"

#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <utility>
#include <vector>

#include "tactile/core/error.hpp"
#include "tactile/transport/deadline.hpp"

namespace tactile::transport {
namespace {

using std::chrono::milliseconds;

constexpr std::size_t packets_at_once = 16;  // handed to the system in one call

std::string refusal(const NetworkAddress& address, const std::string& why) {
  return address.text() + ": cannot listen there (" + why + ")";
}

const char* expected_instead(bool is_unix, bool exists, const std::error_code& error) {
  if (exists) return "; expected a path where there is nothing";
  if (is_unix) return "; expected a path in a folder that is there and may be written to";
  if (error == asio::error::address_in_use) return "; expected a free port of this machine";
  if (error == asio::error::access_denied) return "; expected a port that this user may take, such as one from 1024 on";
  return "; expected an address of this machine, such as 127.0.0.1";
}

std::string text_of(const asio::generic::stream_protocol::endpoint& peer) {
  asio::ip::tcp::endpoint endpoint;
  std::memcpy(endpoint.data(), peer.data(), std::min(peer.size(), endpoint.capacity()));
  const bool is_ipv6 = endpoint.address().is_v6();
  return fmt::format("{}{}{}:{}", is_ipv6 ? "[" : "", endpoint.address().to_string(), is_ipv6 ? "]" : "", endpoint.port());
}

}  // namespace

DvStreamClients::DvStreamClients(const NetworkAddress& address, const DvStreamServerOptions& options, SharedPacket header)
    : address_(address), options_(options), header_(std::move(header)) {
  if (options_.client_queue < 1) throw Error(address_.text() + ": a client's queue of 0 bytes; expected more");
  if (options_.clients < 1) throw Error(address_.text() + ": no client allowed; expected 1 at least");
  listen();
  accept();
  thread_ = std::thread([this] { run(); });
}

DvStreamClients::~DvStreamClients() {
  context_.stop();
  if (thread_.joinable()) thread_.join();
  if (owns_path_) ::unlink(address_.path.c_str());
}

std::vector<asio::generic::stream_protocol::endpoint> DvStreamClients::endpoints() {
  if (address_.kind == NetworkAddress::Kind::unix_socket) return {asio::local::stream_protocol::endpoint(address_.path.string())};
  std::vector<StreamProtocol::endpoint> endpoints;
  std::error_code error;
  asio::ip::tcp::resolver resolver(context_);
  const auto flags = asio::ip::resolver_base::passive | asio::ip::resolver_base::numeric_service;
  for (const auto& found : resolver.resolve(address_.host, std::to_string(address_.port), flags, error)) {
    endpoints.emplace_back(found.endpoint());
  }
  if (error) throw Error(refusal(address_, error.message()) + "; expected a name or an address of this machine");
  return endpoints;
}

void DvStreamClients::listen() {
  const bool is_unix = address_.kind == NetworkAddress::Kind::unix_socket;
  std::error_code error;
  for (const StreamProtocol::endpoint& endpoint : endpoints()) {
    listener_.close(error);
    listener_.open(endpoint.protocol(), error);
    // Otherwise the port of a server that has ended stays blocked for a minute.
    if (!error && !is_unix) listener_.set_option(asio::socket_base::reuse_address(true), error);
    if (!error) listener_.bind(endpoint, error);
    if (!error) owns_path_ = is_unix;
    if (!error) listener_.listen(asio::socket_base::max_listen_connections, error);
    if (error) continue;
    if (!is_unix) {
      asio::ip::tcp::endpoint taken;
      auto size = static_cast<socklen_t>(taken.capacity());
      ::getsockname(listener_.native_handle(), taken.data(), &size);
      address_.port = taken.port();
    }
    return;
  }
  if (owns_path_) ::unlink(address_.path.c_str());
  const bool exists = is_unix && error == asio::error::address_in_use;
  throw Error(refusal(address_, exists ? "the path exists already" : error.message()) + expected_instead(is_unix, exists, error));
}

/// Every handler runs here. If one throws, such as for lack of memory, only its own work ends.
void DvStreamClients::run() {
  for (;;) {
    try {
      context_.run();
      return;
    } catch (const std::exception& e) {
      log(address_.text() + ": " + e.what());
    }
  }
}

void DvStreamClients::log(const std::string& text) const {
  if (options_.log) options_.log(text);
}

void DvStreamClients::accept() {
  auto socket = std::make_shared<StreamProtocol::socket>(context_);
  auto peer = std::make_shared<StreamProtocol::endpoint>();
  listener_.async_accept(*socket, *peer, [this, socket, peer](const std::error_code& error) {
    if (error == asio::error::operation_aborted) return;
    if (!error) {
      accept();
      add(std::move(*socket), *peer);
      return;
    }
    // Too many files are open, or the client has left already. A later attempt may succeed.
    accept_again_.expires_after(milliseconds(100));
    accept_again_.async_wait([this](const std::error_code& cancelled) {
      if (!cancelled) accept();
    });
  });
}

void DvStreamClients::add(StreamProtocol::socket socket, const StreamProtocol::endpoint& peer) {
  std::string name;
  if (peer.protocol().family() == AF_UNIX) {
    name = fmt::format("client {} of {}", joined_ + 1, address_.text());
  } else {
    name = text_of(peer);
    const int yes = 1;
    ::setsockopt(socket.native_handle(), IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
  }
  const auto client = std::make_shared<Client>(std::move(socket), name);
  {
    const std::lock_guard lock(mutex_);
    if (clients_.size() < options_.clients) {
      client->queue.push_back(header_);
      client->queued = header_->size;
      client->writing = true;
      clients_.push_back(client);
      ++joined_;
    } else {
      client->gone = true;
    }
  }
  if (client->gone) {
    log(fmt::format("{} rejected: {} clients are connected, the maximum", name, options_.clients));
    return;
  }
  log(name + " joined");
  watch(client);
  write(client);
}

/// Detects that a client closes its connection. A client must not send anything.
void DvStreamClients::watch(const ClientPointer& client) {
  client->socket.async_read_some(asio::buffer(&client->ignored, 1), [this, client](const std::error_code& error, std::size_t) {
    if (error == asio::error::operation_aborted) return;
    if (!error) {
      remove(client, "it sent data; a client of a DV stream must not", true);
    } else if (error == asio::error::eof || error == asio::error::connection_reset) {
      remove(client, "", false);
    } else {
      remove(client, error.message(), false);
    }
  });
}

/// Hands the front of the queue to the system, and continues until the queue is empty. `writing` is set already.
void DvStreamClients::write(const ClientPointer& client) {
  std::vector<asio::const_buffer> buffers;
  std::vector<SharedPacket> held;  // keeps the bytes until the write is done
  {
    const std::lock_guard lock(mutex_);
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
                                      remove(client, "", false);
                                      return;
                                    }
                                    wrote(client, bytes);
                                    write(client);
                                  });
}

void DvStreamClients::wrote(const ClientPointer& client, std::size_t bytes) {
  {
    const std::lock_guard lock(mutex_);
    if (client->gone) return;
    client->taken += bytes;
    client->queued -= bytes;
    client->sent += bytes;
    while (!client->queue.empty() && client->sent >= client->queue.front()->size) {
      client->sent -= client->queue.front()->size;
      client->queue.pop_front();
    }
  }
  moved_.notify_all();
}

/// On the server's thread. @param is_drop  whether the server drops the client; otherwise the client left
void DvStreamClients::remove(const ClientPointer& client, const std::string& why, bool is_drop) {
  {
    const std::lock_guard lock(mutex_);
    if (client->gone) return;
    client->gone = true;
    if (is_drop) ++dropped_;
    clients_.remove(client);
    client->queue.clear();
    client->queued = 0;
  }
  std::error_code ignored;
  client->socket.close(ignored);
  moved_.notify_all();
  log(client->name + (is_drop ? " dropped: " + why : why.empty() ? " left" : " left: " + why));
}

/// On any thread, while the caller holds the mutex: the client gets no further packets, and the server's thread closes it.
void DvStreamClients::drop_soon(const ClientPointer& client, std::string why) {
  client->gone = true;
  ++dropped_;
  client->queue.clear();
  client->queued = 0;
  asio::post(context_, [this, client, why = std::move(why)] {
    std::error_code ignored;
    client->socket.close(ignored);
    log(client->name + " dropped: " + why);
  });
}

void DvStreamClients::send(const SharedPacket& packet) {
  bool any_dropped = false;
  {
    const std::lock_guard lock(mutex_);
    for (auto at = clients_.begin(); at != clients_.end();) {
      const ClientPointer client = *at;
      if (client->queued > 0 && client->queued + packet->size > options_.client_queue) {
        drop_soon(client, fmt::format("{:.1f} MB unsent", 1e-6 * static_cast<double>(client->queued)));
        at = clients_.erase(at);
        any_dropped = true;
        continue;
      }
      ++at;
      client->queue.push_back(packet);
      client->queued += packet->size;
      if (!std::exchange(client->writing, true)) asio::post(context_, [this, client] { write(client); });
    }
  }
  if (any_dropped) moved_.notify_all();
}

std::size_t DvStreamClients::count() const {
  const std::lock_guard lock(mutex_);
  return clients_.size();
}

std::uint64_t DvStreamClients::joined() const {
  const std::lock_guard lock(mutex_);
  return joined_;
}

std::uint64_t DvStreamClients::dropped() const {
  const std::lock_guard lock(mutex_);
  return dropped_;
}

bool DvStreamClients::wait_for_room(milliseconds patience, const std::function<bool()>& stop) {
  struct Lagging {
    ClientPointer client;
    std::uint64_t taken = 0;
    SteadyClock::time_point since;
  };
  std::vector<Lagging> watched;
  std::unique_lock lock(mutex_);
  for (;;) {
    const SteadyClock::time_point now = SteadyClock::now();
    bool any = false;
    for (auto at = clients_.begin(); at != clients_.end();) {
      const ClientPointer client = *at++;
      if (client->queued <= options_.client_queue / 2) continue;
      const auto known =
          std::find_if(watched.begin(), watched.end(), [&](const Lagging& lagging) { return lagging.client == client; });
      if (known == watched.end()) {
        watched.push_back({.client = client, .taken = client->taken, .since = now});
      } else if (known->taken != client->taken) {
        known->taken = client->taken;
        known->since = now;
      } else if (now - known->since >= patience) {
        drop_soon(client, "it accepted no bytes for " + seconds_text(patience));
        clients_.remove(client);
        continue;
      }
      any = true;
    }
    if (!any) return true;
    lock.unlock();
    if (stop && stop()) return false;
    lock.lock();
    moved_.wait_for(lock, std::min(patience, milliseconds(50)));
  }
}

void DvStreamClients::drain(milliseconds patience) {
  std::unique_lock lock(mutex_);
  const auto is_empty = [&] {
    return std::all_of(clients_.begin(), clients_.end(), [](const auto& client) { return client->queued == 0; });
  };
  moved_.wait_until(lock, deadline_after(patience), is_empty);
}

}  // namespace tactile::transport
