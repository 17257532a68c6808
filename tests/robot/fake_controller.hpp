#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tactile/robot/rtde_protocol.hpp"

namespace tactile::test {

struct FakeControllerOptions {
  std::uint16_t port = 0;  ///< 0: any that is free
  robot::RtdeControllerVersion version{5, 11, 6, 1'071'234};
  double highest_hz = 500;              ///< what a recipe may ask for, and the controller's own rate
  double first_timestamp = 83'456.789;  ///< [s]
  double skew_ppm = 0;                  ///< the controller's clock runs so much faster than the host's
  bool jitter = false;                  ///< packages leave late by 0.2 ms and an exponential of 1 ms, never out of order
  bool split_writes = false;            ///< the stream leaves in pieces that know no package's bounds
  double drop_share = 0;                ///< of the packages, at random
  std::size_t text_every = 0;           ///< a text message ahead of each so manieth package, and of each answer
  bool speaks_version_2 = true;
  bool sends_nan = false;                ///< as the speed of every tenth package
  std::vector<std::string> not_found{};  ///< outputs and inputs that this controller does not have
  std::vector<std::string> in_use{};     ///< inputs that another client writes
  std::uint64_t seed = 1;
};

/// A UR controller on loopback, as far as RTDE version 2 shows one. It repeats a motion of `script_period_s`: the stage is
/// commanded to press by a digital output, then the arm lifts and comes back.
class FakeController {
 public:
  explicit FakeController(FakeControllerOptions options = {});
  ~FakeController();
  FakeController(const FakeController&) = delete;
  FakeController& operator=(const FakeController&) = delete;

  std::uint16_t port() const;

  // Each takes effect before it returns.
  void restart_clock();      ///< the next timestamp counts from 0, the connection stays
  void stall(bool stalled);  ///< connections stay open, packages are not sent, nor later
  void close_connections();
  void listen(bool listening);                    ///< off: connections are refused
  void send_garbage();                            ///< bytes that are no RTDE, to whoever is connected
  void send_half_a_package();                     ///< and closes
  void send_package_of_size(std::uint16_t size);  ///< a data package that claims and has that size, whatever the recipe says

  std::optional<bool> input(const std::string& name) const;  ///< as a client last wrote it; nothing if none has
  std::size_t writes() const;                                ///< packages of inputs so far

  std::vector<double> sent() const;  ///< timestamps of all data packages that were put on their way
  std::size_t accepted() const;      ///< connections so far
  std::size_t not_drained() const;   ///< clients that were dropped since they did not read

 private:
  struct State;
  std::unique_ptr<State> state_;
};

inline constexpr double script_period_s = 6.0;

/// The type of a controller's output, nothing if there is none of that name.
std::optional<robot::RtdeFieldType> fake_output_type(const std::string& name);

/// A field's numbers at a moment of the script [s, >= 0].
std::vector<robot::RtdeNumber> fake_output_at(const robot::RtdeField& field, double script_s);

/// What a controller sends in a session of so many data packages, text messages among it.
std::vector<std::byte> fake_session(std::size_t packages);

}  // namespace tactile::test
