#include "tactile/robot/robot_inputs.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <mutex>

#include "robot/fake_controller.hpp"
#include "support/comes_true.hpp"
#include "support/error_of.hpp"

namespace tactile::robot {
namespace {

using test::comes_true;
using test::FakeController;

RobotInputsOptions options_for(const FakeController& controller, std::vector<int> bits) {
  return {.host = "127.0.0.1", .port = controller.port(), .bits = std::move(bits)};
}

TEST(RobotInputs, AreLowAtFirstThenAsTheyAreSetAndLowAgainInTheEnd) {
  const FakeController controller;
  {
    RobotInputs inputs(options_for(controller, {64, 127}));
    EXPECT_TRUE(comes_true([&] { return controller.input("input_bit_register_127") == false; }));
    std::atomic<bool> written{false};
    inputs.set(0b10, [&] { written = true; });
    EXPECT_TRUE(comes_true([&] { return controller.input("input_bit_register_127") == true; }));
    EXPECT_EQ(controller.input("input_bit_register_64"), false);
    EXPECT_TRUE(comes_true([&] { return written.load(); }));
    inputs.set(0b01);
    EXPECT_TRUE(comes_true([&] { return controller.input("input_bit_register_64") == true; }));
    EXPECT_EQ(controller.input("input_bit_register_127"), false);
    EXPECT_EQ(inputs.state().controller, "5.11.6.1071234");
  }
  EXPECT_TRUE(comes_true([&] { return controller.input("input_bit_register_64") == false; }));
}

TEST(RobotInputs, AreWrittenAgainOnceTheRobotIsBack) {
  FakeController controller;
  std::mutex guard;
  std::string log;
  RobotInputsOptions options = options_for(controller, {70});
  options.log = [&](const std::string& text) {
    const std::scoped_lock lock(guard);
    log += text + "\n";
  };
  RobotInputs inputs(options);
  controller.listen(false);
  controller.close_connections();
  EXPECT_TRUE(comes_true([&] { return !inputs.state().connected; }));
  inputs.set(1);  // nobody waits for the robot
  const std::size_t writes = controller.writes();
  controller.listen(true);
  EXPECT_TRUE(comes_true([&] { return controller.writes() > writes && controller.input("input_bit_register_70") == true; }));
  EXPECT_TRUE(comes_true([&] { return inputs.state().reconnects == 1; }));
  EXPECT_TRUE(comes_true([&] {
    const std::scoped_lock lock(guard);
    return log.find("robot gone (") != std::string::npos && log.find("robot is back after") != std::string::npos;
  })) << log;
}

TEST(RobotInputs, RefuseBitsThatCannotBeWritten) {
  const FakeController controller({.not_found = {"input_bit_register_90"}, .in_use = {"input_bit_register_91"}});
  EXPECT_NE(test::error_of([&] { RobotInputs(options_for(controller, {63})); }).find("expected one from 64 to 127"),
            std::string::npos);
  EXPECT_NE(test::error_of([&] { RobotInputs(options_for(controller, {90})); }).find("has no 'input_bit_register_90'"),
            std::string::npos);
  EXPECT_NE(test::error_of([&] { RobotInputs(options_for(controller, {91})); }).find("is written by another client"),
            std::string::npos);
}

TEST(RobotInputs, OutliveGarbage) {
  FakeController controller;
  RobotInputs inputs(options_for(controller, {64}));
  controller.send_garbage();
  inputs.set(1);
  EXPECT_TRUE(comes_true([&] { return inputs.state().reconnects >= 1; }));
  EXPECT_TRUE(comes_true([&] { return controller.input("input_bit_register_64") == true; }));
}

}  // namespace
}  // namespace tactile::robot
