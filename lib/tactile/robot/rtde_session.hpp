#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/core/error.hpp"
#include "tactile/robot/rtde_protocol.hpp"
#include "tactile/transport/connection.hpp"

namespace tactile::robot {

/// Between two attempts to connect: the pause doubles from the one to the other.
constexpr std::chrono::milliseconds shortest_pause{100}, longest_pause{5'000};

/// The result of the set-up of controller and client.
struct RtdeAgreement {
  RtdeControllerVersion version;
  double frequency_hz = 0;
  RtdeRecipe recipe;
  std::vector<std::string> unknown;  ///< names that the controller does not have; then the recipe is not valid
};

/// One connection to a controller: first the recipe is agreed on, then the controller is started, then it sends packages.
class RtdeSession {
 public:
  using Report = std::function<void(const std::string&)>;

  /// @param patience  with the connection and with each answer, > 0
  /// @param report    gets the controller's text messages, in printable form
  /// @throws Error    if there is no controller
  RtdeSession(const transport::NetworkAddress& address, std::chrono::milliseconds patience, Report report);

  /// @param frequency_hz  0: the controller's highest, 125 below version 5, else 500
  /// @throws Error        if it speaks no RTDE 2 or refuses, but not for names that it does not have
  RtdeAgreement agree(const std::vector<std::string>& names, double frequency_hz);

  /// Agrees on the inputs that this client writes and that no other client may write: `unknown` names inputs that the controller
  /// does not have. @throws Error  if it speaks no RTDE 2, or another client writes one of them already
  RtdeAgreement agree_on_inputs(const std::vector<std::string>& names);

  /// Sends numbers of inputs that were agreed on. @throws Error  if the connection is over, or the controller does not accept the
  /// bytes within `patience`
  void write(const RtdeRecipe& recipe, std::span<const RtdeNumber> numbers, std::chrono::milliseconds patience);

  void start();  ///< @throws Error if the controller refuses
  void pause();  ///< asks it to end; does not wait for the answer

  /// Waits up to `patience` for bytes; false if none came. @throws Error if the connection is over
  bool receive(std::chrono::milliseconds patience);

  /// The next whole package; text messages are reported and left out. Its payload is valid until the next `receive`.
  std::optional<RtdePackage> next();

  /// Runs `step` and names the controller in what it throws.
  template <class Step>
  auto checked(Step&& step) const -> decltype(step()) {
    try {
      return step();
    } catch (const Error& e) {
      refuse(std::string("the controller sent ") + e.what());
    }
  }

 private:
  [[noreturn]] void refuse(const std::string& what) const;
  void send(const std::vector<std::byte>& package);
  RtdeControllerVersion greet();
  RtdeFieldType type_of(const std::string& name, const std::string& type) const;
  std::string last_words() const;
  template <class Answer>
  Answer answer_to(RtdePackageType type, std::string_view what, Answer (*read)(std::span<const std::byte>));

  transport::Connection connection_;
  std::chrono::milliseconds patience_;
  Report report_;
  std::vector<std::byte> buffer_;
  RtdeReassembly reassembly_;
  std::string last_words_;
};

}  // namespace tactile::robot
