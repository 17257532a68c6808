#include "robot/fake_outputs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "robot/fake_controller.hpp"

namespace tactile::test {
namespace {

// The script: what the stage is commanded to do, and the lift's trapezoid.
constexpr double press_s = 1.0, lift_s = 2.5, lower_s = 4.2, release_s = 5.5;
constexpr double lift_speed = 0.06, lift_acceleration = 1.2, lift_length_s = 1.0;

double trapezoid(double since_start_s) {
  if (since_start_s <= 0 || since_start_s >= lift_length_s) return 0;
  return std::min({lift_speed, lift_acceleration * since_start_s, lift_acceleration * (lift_length_s - since_start_s)});
}

/// The displacement by the trapezoid until then.
double travelled(double since_start_s) {
  const double ramp_s = lift_speed / lift_acceleration;
  const double t = std::clamp(since_start_s, 0.0, lift_length_s);
  const double rising = std::min(t, ramp_s);
  const double falling = std::max(0.0, t - (lift_length_s - ramp_s));
  const double level = std::clamp(t - ramp_s, 0.0, lift_length_s - 2 * ramp_s);
  return lift_acceleration * rising * rising / 2 + lift_speed * level + lift_speed * falling -
         lift_acceleration * falling * falling / 2;
}

const std::map<std::string, robot::RtdeFieldType>& plain_outputs() {
  using enum robot::RtdeFieldType;
  static const std::map<std::string, robot::RtdeFieldType> outputs = [] {
    std::map<std::string, robot::RtdeFieldType> types;
    const auto all = [&](robot::RtdeFieldType type, std::initializer_list<const char*> names) {
      for (const char* name : names) types[name] = type;
    };
    all(real, {"timestamp",
               "actual_execution_time",
               "speed_scaling",
               "target_speed_fraction",
               "actual_momentum",
               "actual_main_voltage",
               "actual_robot_voltage",
               "actual_robot_current",
               "standard_analog_input0",
               "standard_analog_input1",
               "standard_analog_output0",
               "standard_analog_output1",
               "io_current",
               "tool_analog_input0",
               "tool_analog_input1",
               "tool_output_current",
               "tool_temperature",
               "tcp_force_scalar",
               "payload",
               "joint_position_deviation_ratio",
               "collision_detection_ratio"});
    all(vector6, {"target_q", "target_qd", "target_qdd", "target_current", "target_moment", "actual_q", "actual_qd",
                  "actual_current", "actual_current_as_torque", "joint_control_output", "actual_TCP_pose", "actual_TCP_speed",
                  "actual_TCP_force", "target_TCP_pose", "target_TCP_speed", "joint_temperatures", "actual_joint_voltage",
                  "ft_raw_wrench", "payload_inertia"});
    all(vector3, {"actual_tool_accelerometer", "payload_cog", "elbow_position", "elbow_velocity"});
    all(vector6_int32, {"joint_mode"});
    all(uint64, {"actual_digital_input_bits", "actual_digital_output_bits"});
    all(uint32, {"runtime_state", "robot_status_bits", "safety_status_bits", "analog_io_types", "output_bit_registers0_to_31",
                 "output_bit_registers32_to_63", "tool_mode", "script_control_line"});
    all(int32, {"robot_mode", "safety_mode", "safety_status", "tool_output_voltage", "time_scale_source"});
    all(uint8, {"tool_output_mode"});
    return types;
  }();
  return outputs;
}

/// The number after `prefix`, below `count`.
std::optional<int> register_in(const std::string& name, const std::string& prefix, int first, int count) {
  if (!name.starts_with(prefix)) return std::nullopt;
  for (int i = first; i < first + count; ++i) {
    if (name == prefix + std::to_string(i)) return i;
  }
  return std::nullopt;
}

}  // namespace

std::optional<robot::RtdeFieldType> fake_output_type(const std::string& name) {
  if (const auto found = plain_outputs().find(name); found != plain_outputs().end()) return found->second;
  if (register_in(name, "output_bit_register_", 64, 64)) return robot::RtdeFieldType::boolean;
  if (register_in(name, "output_int_register_", 0, 48)) return robot::RtdeFieldType::int32;
  if (register_in(name, "output_double_register_", 0, 48)) return robot::RtdeFieldType::real;
  return std::nullopt;
}

std::vector<robot::RtdeNumber> fake_output_at(const robot::RtdeField& field, double script_s) {
  const double t = std::fmod(script_s, script_period_s);
  const double speed = trapezoid(t - lift_s) - trapezoid(t - lower_s);
  const double height = 0.25 + travelled(t - lift_s) - travelled(t - lower_s);
  const bool pressed = t >= press_s && t < release_s;
  const bool lifting = t >= lift_s && t < lift_s + lift_length_s;
  const std::int64_t phase = !pressed ? 0 : lifting ? 2 : t >= lower_s ? 3 : 1;
  const auto whole = [&](std::uint64_t value) { return std::vector<robot::RtdeNumber>{value}; };
  const auto number = [&](std::int64_t value) { return std::vector<robot::RtdeNumber>{value}; };
  const auto vector = [&](std::initializer_list<double> values) {
    return std::vector<robot::RtdeNumber>(values.begin(), values.end());
  };

  if (field.name == "actual_TCP_pose" || field.name == "target_TCP_pose") return vector({-0.5, 0.2, height, 2.2, -2.2, 0.01});
  if (field.name == "actual_TCP_speed" || field.name == "target_TCP_speed") return vector({1e-5, -2e-5, speed, 0, 0, 0});
  if (field.name == "actual_TCP_force") return vector({0.1, 0.2, lifting ? -4.5 : 0.3, 0, 0, 0});
  if (field.name == "actual_tool_accelerometer") return vector({0.02, -0.03, 9.81});
  if (field.name == "actual_digital_output_bits") return whole(pressed ? 0x1'0001U : 0x1'0000U);
  if (field.name == "actual_digital_input_bits") return whole(std::uint64_t{1} << 17 | (lifting ? 2U : 0U));
  if (field.name == "output_bit_registers0_to_31") return whole(lifting ? 0x8000'0000U : 0U);
  if (field.name == "output_bit_register_64") return whole(t >= 0.5 && t < 5.8 ? 1U : 0U);
  if (field.name == "output_int_register_0") return number(phase);
  if (field.name == "output_int_register_1") return number(-phase);
  if (field.name == "output_double_register_0") return vector({speed});
  if (field.name == "runtime_state") return whole(2);
  if (field.name == "robot_mode") return number(7);
  if (field.name == "safety_mode" || field.name == "safety_status") return number(1);
  if (field.name == "speed_scaling" || field.name == "target_speed_fraction") return vector({1.0});

  const std::size_t count = robot::numbers_in(field.type);
  std::vector<robot::RtdeNumber> numbers;
  for (std::size_t i = 0; i < count; ++i) {
    switch (field.type) {
      case robot::RtdeFieldType::real:
      case robot::RtdeFieldType::vector3:
      case robot::RtdeFieldType::vector6:
        numbers.emplace_back(0.1 * static_cast<double>(i) + height);
        break;
      case robot::RtdeFieldType::int32:
      case robot::RtdeFieldType::vector6_int32:
        numbers.emplace_back(std::int64_t{253});
        break;
      default:
        numbers.emplace_back(std::uint64_t{0});
    }
  }
  return numbers;
}

robot::RtdeSetupReply types_for(const robot::RtdeOutputsRequest& request, const std::vector<std::string>& not_found,
                                robot::RtdeRecipe& recipe) {
  robot::RtdeSetupReply reply{.recipe_id = 1, .types = {}};
  recipe = {.id = 1, .fields = {}};
  for (const std::string& name : request.names) {
    const auto type =
        std::find(not_found.begin(), not_found.end(), name) == not_found.end() ? fake_output_type(name) : std::nullopt;
    reply.types.emplace_back(type ? name_of(*type) : "NOT_FOUND");
    if (type) {
      recipe.fields.push_back({name, *type});
    } else {
      reply.recipe_id = 0;
    }
  }
  return reply;
}

std::vector<robot::RtdeNumber> numbers_for(const robot::RtdeRecipe& recipe, double timestamp, double script_s) {
  std::vector<robot::RtdeNumber> numbers;
  for (const robot::RtdeField& field : recipe.fields) {
    const auto values = field.name == "timestamp" ? std::vector<robot::RtdeNumber>{timestamp} : fake_output_at(field, script_s);
    numbers.insert(numbers.end(), values.begin(), values.end());
  }
  return numbers;
}

std::vector<std::byte> fake_session(std::size_t packages) {
  std::vector<std::byte> bytes;
  const auto add = [&](const std::vector<std::byte>& package) { bytes.insert(bytes.end(), package.begin(), package.end()); };
  const robot::RtdeOutputsRequest request{
      500,
      {"timestamp", "actual_TCP_pose", "actual_TCP_speed", "actual_digital_output_bits", "joint_mode", "robot_mode",
       "runtime_state", "actual_tool_accelerometer", "output_bit_register_64"}};
  robot::RtdeRecipe recipe;
  const robot::RtdeSetupReply reply = types_for(request, {}, recipe);
  add(robot::rtde_accepted_reply(robot::RtdePackageType::protocol_version, true));
  add(robot::rtde_controller_version_reply({5, 11, 6, 1'071'234}));
  add(robot::rtde_setup_reply(robot::RtdePackageType::setup_outputs, reply));
  add(robot::rtde_text_message({"a program runs", "RTDE", 3}));
  add(robot::rtde_accepted_reply(robot::RtdePackageType::start, true));
  for (std::size_t i = 0; i < packages; ++i) {
    const double script_s = static_cast<double>(i) * 0.002;
    add(robot::rtde_data_package(recipe, numbers_for(recipe, 83'456.789 + script_s, script_s)));
  }
  return bytes;
}

}  // namespace tactile::test
