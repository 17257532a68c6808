#include "tactile/robot/robot_inputs.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/robot/rtde_session.hpp"

namespace tactile::robot {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds write_patience{100};
constexpr milliseconds look{100};  // from one check of the connection to the next

}  // namespace

struct RobotInputs::State {
  RobotInputsOptions options;
  transport::NetworkAddress address;
  std::vector<std::string> names;
  std::optional<RtdeSession> session;  ///< used by the thread only, once that runs
  RtdeRecipe recipe;

  mutable std::mutex guard;  ///< of all that follows
  std::condition_variable wake;
  std::uint64_t wanted = 0;
  std::function<void()> written;
  bool is_new = false, stops = false;
  RobotInputsState state;

  std::thread thread;

  void connect();
  void write(std::uint64_t high);
  void work();
  bool serve();
  bool connect_again(const std::string& why);
};

void RobotInputs::State::connect() {
  session.reset();
  // The robot's messages belong in its own log.
  RtdeSession fresh(address, options.patience, [](const std::string&) {});
  const RtdeAgreement agreed = fresh.agree_on_inputs(names);
  if (!agreed.unknown.empty()) {
    throw Error(fmt::format("{}: the controller, of version {}, has no '{}'; expected an input bit register that it has",
                            address.text(), text_of(agreed.version), agreed.unknown.front()));
  }
  fresh.start();
  recipe = agreed.recipe;
  session.emplace(std::move(fresh));
  const std::scoped_lock lock(guard);
  state.connected = true;
  state.controller = text_of(agreed.version);
}

void RobotInputs::State::write(std::uint64_t high) {
  std::vector<RtdeNumber> numbers;
  for (std::size_t i = 0; i < names.size(); ++i) numbers.emplace_back(std::uint64_t{high >> i & 1U});
  session->write(recipe, numbers, write_patience);
  const std::scoped_lock lock(guard);
  ++state.writes;
}

/// Writes the bits until the end or until the controller is gone. @return false at the end. @throws Error if it is gone
bool RobotInputs::State::serve() {
  for (;;) {
    std::unique_lock lock(guard);
    wake.wait_for(lock, look, [this] { return is_new || stops; });
    if (std::exchange(is_new, false)) {
      const std::uint64_t high = wanted;
      const std::function<void()> report_written = std::exchange(written, {});
      lock.unlock();
      try {
        write(high);
      } catch (const Error&) {
        lock.lock();
        is_new = true;  // written once the robot is back, unless others are set
        throw;
      }
      if (report_written) report_written();
      continue;
    }
    if (stops) return false;
    lock.unlock();
    session->receive(milliseconds(0));  // text messages, or that it has closed
    while (session->next()) {
    }
  }
}

bool RobotInputs::State::connect_again(const std::string& why) {
  if (options.log) options.log(fmt::format("robot gone ({}), trying again", why));
  const auto gone = std::chrono::steady_clock::now();
  for (milliseconds pause = shortest_pause;; pause = std::min(2 * pause, longest_pause)) {
    {
      std::unique_lock lock(guard);
      state.connected = false;
      if (wake.wait_for(lock, pause, [this] { return stops; })) return false;
    }
    try {
      connect();
      std::uint64_t high = 0;
      {
        const std::scoped_lock lock(guard);
        high = wanted;
        is_new = false;
        ++state.reconnects;
      }
      write(high);
      const std::chrono::duration<double> lasted = std::chrono::steady_clock::now() - gone;
      if (options.log) options.log(fmt::format("robot is back after {:.1f} s", lasted.count()));
      return true;
    } catch (const Error&) {
      continue;
    }
  }
}

void RobotInputs::State::work() {
  if (options.prepare) options.prepare();
  for (bool goes_on = true; goes_on;) {
    try {
      goes_on = serve();
    } catch (const Error& e) {
      goes_on = connect_again(e.what());
    }
  }
}

RobotInputs::RobotInputs(RobotInputsOptions options) : state_(std::make_unique<State>()) {
  State& state = *state_;
  state.options = std::move(options);
  state.address = {
      .kind = transport::NetworkAddress::Kind::tcp, .host = state.options.host, .port = state.options.port, .path = {}};
  for (const int bit : state.options.bits) {
    if (bit < 64 || bit > 127)
      throw Error(fmt::format("input bit register {}; expected one from 64 to 127, which RTDE clients may write", bit));
    state.names.push_back(fmt::format("input_bit_register_{}", bit));
  }
  state.connect();
  state.write(0);
  state.thread = std::thread([&state] { state.work(); });
}

RobotInputs::~RobotInputs() {
  State& state = *state_;
  {
    const std::scoped_lock lock(state.guard);
    state.wanted = 0;
    state.is_new = true;
    state.stops = true;
  }
  state.wake.notify_all();
  state.thread.join();
}

void RobotInputs::set(std::uint64_t high, std::function<void()> written) {
  {
    const std::scoped_lock lock(state_->guard);
    state_->wanted = high;
    state_->written = std::move(written);
    state_->is_new = true;
  }
  state_->wake.notify_all();
}

RobotInputsState RobotInputs::state() const {
  const std::scoped_lock lock(state_->guard);
  return state_->state;
}

}  // namespace tactile::robot
