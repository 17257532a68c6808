#include "robot/fake_controller.hpp"

#include <fcntl.h>
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <asio.hpp>
#include <atomic>
#include <chrono>
#include <cmath>
#include <future>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <thread>
#include <utility>

#include "robot/fake_outputs.hpp"
#include "support/held_port.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"

namespace tactile::test {
namespace {

using asio::ip::tcp;
using SteadyClock = std::chrono::steady_clock;

constexpr std::size_t longest_piece = 3'000;                  // [bytes] of a stream that leaves in pieces
constexpr std::size_t most_undrained = std::size_t{1} << 20;  // [bytes] then the client is dropped, as a controller does

std::byte byte_of(int value) { return static_cast<std::byte>(value); }

/// What all connections share; the server's thread alone touches it, but for what is atomic or guarded by the mutex.
struct Shared {
  FakeControllerOptions options;
  Random random{1};
  SteadyClock::time_point begin = SteadyClock::now();
  double clock_base = 0;  ///< timestamp at tick `clock_begin`
  std::int64_t clock_begin = 0;
  bool restart_wanted = false;
  bool stalled = false;

  std::mutex mutex;
  std::vector<double> sent;
  std::map<std::string, bool> inputs;
  std::size_t writes = 0;
  std::atomic<std::size_t> accepted{0};
  std::atomic<std::size_t> not_drained{0};

  /// When tick n happens, by the host's clock.
  SteadyClock::time_point moment_of(std::int64_t tick) const {
    const double seconds = static_cast<double>(tick) / (options.highest_hz * (1 + options.skew_ppm * 1e-6));
    return begin + std::chrono::duration_cast<SteadyClock::duration>(std::chrono::duration<double>(seconds));
  }
  std::int64_t tick_now() const {
    const double seconds = std::chrono::duration<double>(SteadyClock::now() - begin).count();
    return static_cast<std::int64_t>(seconds * options.highest_hz * (1 + options.skew_ppm * 1e-6));
  }
  /// The same for every client, so that two logs can be compared.
  bool is_dropped(std::int64_t tick) const {
    if (options.drop_share <= 0) return false;
    return Random(options.seed ^ static_cast<std::uint64_t>(tick) << 8).uniform() < options.drop_share;
  }
  double timestamp_of(std::int64_t tick) const {
    return clock_base + static_cast<double>(tick - clock_begin) / options.highest_hz;
  }
};

class Client : public std::enable_shared_from_this<Client> {
 public:
  Client(tcp::socket socket, Shared& shared)
      : shared_(shared), socket_(std::move(socket)), ticks_(socket_.get_executor()), writes_(socket_.get_executor()) {
    socket_.set_option(tcp::no_delay(true));
  }

  void run() { read(); }

  void close() {
    std::error_code ignored;
    closed_ = true;
    ticks_.cancel();
    writes_.cancel();
    socket_.shutdown(tcp::socket::shutdown_both, ignored);
    socket_.close(ignored);
  }

  bool is_closed() const { return closed_; }

  void send(const std::vector<std::byte>& bytes) {
    if (closed_ || close_when_written_) return;
    if (out_.size() + bytes.size() > most_undrained) {
      ++shared_.not_drained;
      close();
      return;
    }
    out_.insert(out_.end(), bytes.begin(), bytes.end());
    write();
  }

  /// What is left when all is written is nothing.
  void close_after(const std::vector<std::byte>& bytes) {
    send(bytes);
    close_when_written_ = true;
  }

  const robot::RtdeRecipe& recipe() const { return recipe_; }

 private:
  void read() {
    socket_.async_read_some(asio::buffer(in_), [self = shared_from_this()](std::error_code error, std::size_t size) {
      if (error) {
        self->close();
        return;
      }
      self->reassembly_.append(std::span<const std::byte>(self->in_).first(size));
      try {
        while (const auto package = self->reassembly_.next()) self->answer(*package);
      } catch (const Error&) {
        self->close();
      }
      if (!self->closed_) self->read();
    });
  }

  void chat() {
    if (shared_.options.text_every > 0) send(robot::rtde_text_message({"please stand by", "RTDE", 2}));
  }

  void answer(const robot::RtdePackage& package) {
    chat();
    switch (package.type) {
      case robot::RtdePackageType::protocol_version:
        send(robot::rtde_accepted_reply(package.type,
                                        shared_.options.speaks_version_2 && robot::protocol_version_in(package.payload) == 2));
        break;
      case robot::RtdePackageType::controller_version:
        send(robot::rtde_controller_version_reply(shared_.options.version));
        break;
      case robot::RtdePackageType::setup_outputs: {
        const robot::RtdeOutputsRequest request = robot::outputs_request_in(package.payload);
        robot::RtdeSetupReply reply = types_for(request, shared_.options.not_found, recipe_);
        if (!(request.frequency_hz > 0 && request.frequency_hz <= shared_.options.highest_hz)) {
          send(robot::rtde_text_message(
              {fmt::format("{} Hz is more than {}", request.frequency_hz, shared_.options.highest_hz), "RTDE", 1}));
          reply.recipe_id = 0;
        }
        valid_ = reply.recipe_id != 0;
        step_ = std::max<std::int64_t>(1, std::llround(shared_.options.highest_hz / std::max(1.0, request.frequency_hz)));
        send(robot::rtde_setup_reply(package.type, reply));
        break;
      }
      case robot::RtdePackageType::setup_inputs:
        send(robot::rtde_setup_reply(package.type, take_inputs(robot::inputs_request_in(package.payload))));
        break;
      case robot::RtdePackageType::start:
        send(robot::rtde_accepted_reply(package.type, valid_ || !inputs_.fields.empty()));
        if (valid_ && !std::exchange(started_, true)) {
          tick_ = (shared_.tick_now() / step_ + 1) * step_;
          due_ = SteadyClock::time_point::min();
          wait_for_tick();
        }
        break;
      case robot::RtdePackageType::pause:
        started_ = false;
        send(robot::rtde_accepted_reply(package.type, true));
        break;
      case robot::RtdePackageType::data:
        if (robot::read_rtde_data(inputs_, package.payload, numbers_)) {
          const std::lock_guard lock(shared_.mutex);
          ++shared_.writes;
          for (std::size_t i = 0; i < numbers_.size(); ++i)
            shared_.inputs[inputs_.fields[i].name] = robot::as_double(numbers_[i]) != 0;
        }
        break;
      case robot::RtdePackageType::text:
        break;
    }
  }

  /// Bit registers 64 to 127, as a controller of version 5 leaves them to clients other than its fieldbus.
  robot::RtdeSetupReply take_inputs(const std::vector<std::string>& names) {
    const auto is_among = [](const std::vector<std::string>& all, const std::string& name) {
      return std::find(all.begin(), all.end(), name) != all.end();
    };
    robot::RtdeSetupReply reply{.recipe_id = 2, .types = {}};
    inputs_ = {.id = 2, .fields = {}};
    for (const std::string& name : names) {
      constexpr std::string_view begin = "input_bit_register_";
      const int number = name.starts_with(begin) ? std::atoi(name.c_str() + begin.size()) : 0;
      const bool is_there = number >= 64 && number <= 127 && !is_among(shared_.options.not_found, name);
      const bool is_free = !is_among(shared_.options.in_use, name);
      reply.types.emplace_back(!is_there ? "NOT_FOUND" : !is_free ? "IN_USE" : "BOOL");
      if (is_there && is_free) inputs_.fields.push_back({name, robot::RtdeFieldType::boolean});
    }
    if (inputs_.fields.size() == names.size()) return reply;
    inputs_.fields.clear();
    reply.recipe_id = 0;
    return reply;
  }

  void wait_for_tick() {
    double late_s = 0;
    if (shared_.options.jitter) late_s = 0.2e-3 + 1e-3 * shared_.random.exponential();
    const auto late = std::chrono::duration_cast<SteadyClock::duration>(std::chrono::duration<double>(late_s));
    due_ = std::max(due_, shared_.moment_of(tick_) + late);
    if (due_ <= SteadyClock::now()) {  // a busy machine: packages leave together
      asio::post(socket_.get_executor(), [self = shared_from_this()] { self->tick(); });
      return;
    }
    ticks_.expires_at(due_);
    ticks_.async_wait([self = shared_from_this()](std::error_code error) {
      if (!error) self->tick();
    });
  }

  void tick() {
    if (closed_ || !started_) return;
    if (std::exchange(shared_.restart_wanted, false)) {
      shared_.clock_base = 0;
      shared_.clock_begin = tick_;
    }
    if (!shared_.stalled && !shared_.is_dropped(tick_)) send_data();
    tick_ += step_;
    wait_for_tick();
  }

  void send_data() {
    const double timestamp = shared_.timestamp_of(tick_);
    if (shared_.options.text_every > 0 && packages_ % shared_.options.text_every == 0) chat();
    std::vector<robot::RtdeNumber> numbers =
        numbers_for(recipe_, timestamp, static_cast<double>(tick_) / shared_.options.highest_hz);
    if (shared_.options.sends_nan && packages_ % 10 == 9) {
      const auto columns = robot::columns_of(recipe_);
      const auto speed = std::find(columns.begin(), columns.end(), "actual_TCP_speed_2");
      numbers[static_cast<std::size_t>(speed - columns.begin())] = std::nan("");
    }
    ++packages_;
    {
      const std::lock_guard lock(shared_.mutex);
      shared_.sent.push_back(timestamp);
    }
    send(robot::rtde_data_package(recipe_, numbers));
  }

  void write() {
    if (writing_ || closed_) return;
    if (out_.empty()) {
      if (close_when_written_) close();
      return;
    }
    const bool split = shared_.options.split_writes;
    // The more there is, the longer the pieces: a timer that fires late, on a busy machine, must hold nothing up for long.
    const std::size_t size =
        split ? std::min(out_.size(), 1 + shared_.random.below(std::max(longest_piece, out_.size()))) : out_.size();
    going_.assign(out_.begin(), out_.begin() + static_cast<std::ptrdiff_t>(size));
    out_.erase(out_.begin(), out_.begin() + static_cast<std::ptrdiff_t>(size));
    writing_ = true;
    asio::async_write(socket_, asio::buffer(going_), [self = shared_from_this(), split](std::error_code error, std::size_t) {
      if (error) {
        self->close();
        return;
      }
      if (!split) {
        self->writing_ = false;
        self->write();
        return;
      }
      // A pause lets the next piece hold the end of one package and the start of another.
      self->writes_.expires_after(std::chrono::microseconds(self->shared_.random.below(3'000)));
      self->writes_.async_wait([self](std::error_code cancelled) {
        self->writing_ = false;
        if (!cancelled) self->write();
      });
    });
  }

  Shared& shared_;
  tcp::socket socket_;
  asio::steady_timer ticks_, writes_;
  std::array<std::byte, 4096> in_{};
  robot::RtdeReassembly reassembly_;
  std::vector<std::byte> out_, going_;
  bool writing_ = false, closed_ = false, close_when_written_ = false;
  robot::RtdeRecipe recipe_, inputs_;
  std::vector<robot::RtdeNumber> numbers_;
  bool valid_ = false, started_ = false;
  std::int64_t step_ = 1, tick_ = 0;
  SteadyClock::time_point due_{};
  std::size_t packages_ = 0;
};

}  // namespace

struct FakeController::State {
  Shared shared;
  asio::io_context context;
  asio::executor_work_guard<asio::io_context::executor_type> stays_up = asio::make_work_guard(context);  // with no client too
  tcp::acceptor acceptor{context};
  std::vector<std::weak_ptr<Client>> clients;
  std::uint16_t port = 0;
  std::optional<HeldPort> held;  ///< while nobody listens
  std::thread thread;

  void open() {
    const tcp::endpoint endpoint(asio::ip::address_v4::loopback(), port);
    acceptor.open(endpoint.protocol());
    ::fcntl(acceptor.native_handle(), F_SETFD, FD_CLOEXEC);  // a command that a test starts would keep it open
    acceptor.set_option(tcp::acceptor::reuse_address(true));
    acceptor.bind(endpoint);
    acceptor.listen();
    port = acceptor.local_endpoint().port();
    accept();
  }

  void accept() {
    acceptor.async_accept([this](std::error_code error, tcp::socket socket) {
      if (error) return;
      ++shared.accepted;
      const auto client = std::make_shared<Client>(std::move(socket), shared);
      std::erase_if(clients, [](const auto& old) { return old.expired(); });
      clients.push_back(client);
      client->run();
      accept();
    });
  }

  template <class Use>
  void for_clients(Use use) {
    for (const auto& weak : clients) {
      if (const auto client = weak.lock(); client && !client->is_closed()) use(*client);
    }
  }

  /// Does it on the server's thread and waits for it.
  template <class Step>
  void now(Step step) {
    std::promise<void> done;
    asio::post(context, [&] {
      step();
      done.set_value();
    });
    done.get_future().wait();
  }
};

FakeController::FakeController(FakeControllerOptions options) : state_(std::make_unique<State>()) {
  state_->port = options.port;
  state_->shared.random = Random(options.seed);
  state_->shared.clock_base = options.first_timestamp;
  state_->shared.options = std::move(options);
  state_->open();
  state_->thread = std::thread([state = state_.get()] { state->context.run(); });
}

FakeController::~FakeController() {
  state_->now([&] {
    std::error_code ignored;
    state_->acceptor.close(ignored);
    state_->for_clients([](Client& client) { client.close(); });
    state_->stays_up.reset();
  });
  state_->thread.join();
}

std::uint16_t FakeController::port() const { return state_->port; }

void FakeController::restart_clock() {
  state_->now([&] { state_->shared.restart_wanted = true; });
}

void FakeController::stall(bool stalled) {
  state_->now([&] { state_->shared.stalled = stalled; });
}

void FakeController::close_connections() {
  state_->now([&] { state_->for_clients([](Client& client) { client.close(); }); });
}

void FakeController::listen(bool listening) {
  state_->now([&] {
    std::error_code ignored;
    if (listening == state_->acceptor.is_open()) return;
    if (listening) {
      state_->open();
      state_->held.reset();
    } else {
      state_->acceptor.close(ignored);
      state_->held.emplace(state_->port);
    }
  });
}

void FakeController::send_garbage() {
  state_->now([&] {
    std::vector<std::byte> bytes{byte_of(0), byte_of(40), byte_of(0xFE)};
    for (int i = 0; i < 37; ++i) bytes.push_back(byte_of(static_cast<int>(state_->shared.random.below(256))));
    state_->for_clients([&](Client& client) { client.send(bytes); });
  });
}

void FakeController::send_half_a_package() {
  state_->now([&] {
    state_->for_clients([](Client& client) {
      std::vector<std::byte> package = robot::rtde_data_package(client.recipe(), numbers_for(client.recipe(), 1.0, 0.0));
      package.resize(package.size() / 2);
      client.close_after(package);
    });
  });
}

void FakeController::send_package_of_size(std::uint16_t size) {
  state_->now([&] {
    state_->for_clients([&](Client& client) {
      std::vector<std::byte> package(std::max<std::size_t>(size, 4), std::byte{1});
      package[0] = byte_of(size >> 8);
      package[1] = byte_of(size & 0xFF);
      package[2] = byte_of('U');
      client.send(package);
    });
  });
}

std::vector<double> FakeController::sent() const {
  const std::lock_guard lock(state_->shared.mutex);
  return state_->shared.sent;
}

std::optional<bool> FakeController::input(const std::string& name) const {
  const std::lock_guard lock(state_->shared.mutex);
  const auto found = state_->shared.inputs.find(name);
  return found == state_->shared.inputs.end() ? std::nullopt : std::optional(found->second);
}
std::size_t FakeController::writes() const {
  const std::lock_guard lock(state_->shared.mutex);
  return state_->shared.writes;
}

std::size_t FakeController::accepted() const { return state_->shared.accepted; }
std::size_t FakeController::not_drained() const { return state_->shared.not_drained; }

}  // namespace tactile::test
