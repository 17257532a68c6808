#include "tactile/robot/rtde_protocol.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <tuple>

#include "robot/fake_controller.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"

namespace tactile::robot {
namespace {

using Bytes = std::vector<std::byte>;

Bytes bytes(std::initializer_list<int> values) {
  Bytes all;
  for (const int value : values) all.push_back(static_cast<std::byte>(value));
  return all;
}

Bytes payload_of(const Bytes& package) { return {package.begin() + 3, package.end()}; }

template <class Step>
std::string complaint_of(Step step) {
  try {
    step();
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(RtdeProtocol, HasTheBytesThatControllersKnow) {
  EXPECT_EQ(rtde_protocol_version_request(2), bytes({0, 5, 0x56, 0, 2}));
  EXPECT_EQ(rtde_accepted_reply(RtdePackageType::protocol_version, true), bytes({0, 4, 0x56, 1}));
  EXPECT_EQ(rtde_bare_request(RtdePackageType::controller_version), bytes({0, 3, 0x76}));
  EXPECT_EQ(rtde_bare_request(RtdePackageType::start), bytes({0, 3, 0x53}));
  EXPECT_EQ(rtde_accepted_reply(RtdePackageType::start, true), bytes({0, 4, 0x53, 1}));
  EXPECT_EQ(rtde_bare_request(RtdePackageType::pause), bytes({0, 3, 0x50}));
  EXPECT_EQ(rtde_controller_version_reply({3, 15, 8, 106'339}),
            bytes({0, 19, 0x76, 0, 0, 0, 3, 0, 0, 0, 15, 0, 0, 0, 8, 0, 1, 0x9F, 0x63}));
  // 125 is 0x405F400000000000 as a double.
  EXPECT_EQ(rtde_setup_outputs_request({125, {"a", "bc"}}),
            bytes({0, 15, 0x4F, 0x40, 0x5F, 0x40, 0, 0, 0, 0, 0, 'a', ',', 'b', 'c'}));
  EXPECT_EQ(rtde_setup_reply(RtdePackageType::setup_outputs, {7, {"BOOL", "INT32"}}),
            bytes({0, 14, 0x4F, 7, 'B', 'O', 'O', 'L', ',', 'I', 'N', 'T', '3', '2'}));
  EXPECT_EQ(rtde_text_message({"hi", "me", 2}), bytes({0, 10, 0x4D, 2, 'h', 'i', 2, 'm', 'e', 2}));
}

TEST(RtdeProtocol, PacksADataPackageFieldAfterField) {
  const RtdeRecipe recipe{.id = 3,
                          .fields = {{"flag", RtdeFieldType::boolean},
                                     {"small", RtdeFieldType::uint8},
                                     {"mode", RtdeFieldType::int32},
                                     {"state", RtdeFieldType::uint32},
                                     {"bits", RtdeFieldType::uint64},
                                     {"time", RtdeFieldType::real}}};
  const std::vector<RtdeNumber> numbers{
      std::uint64_t{1}, std::uint64_t{200}, std::int64_t{-1}, std::uint64_t{0x80000001}, std::uint64_t{0x8000000000000002}, 1.0};
  const Bytes package = rtde_data_package(recipe, numbers);
  EXPECT_EQ(package, bytes({0, 30, 0x55, 3, 1, 200, 0xFF, 0xFF, 0xFF, 0xFF, 0x80, 0, 0, 1, 0x80,
                            0, 0,  0,    0, 0, 0,   2,    0x3F, 0xF0, 0,    0,    0, 0, 0, 0}));
  std::vector<RtdeNumber> back;
  ASSERT_TRUE(read_rtde_data(recipe, payload_of(package), back));
  EXPECT_EQ(back, numbers);
}

TEST(RtdeProtocol, KnowsEveryTypesSize) {
  using enum RtdeFieldType;
  const std::vector<std::tuple<std::string, RtdeFieldType, std::size_t, std::size_t>> types{
      {"BOOL", boolean, 1, 1},
      {"UINT8", uint8, 1, 1},
      {"UINT32", uint32, 1, 4},
      {"UINT64", uint64, 1, 8},
      {"INT32", int32, 1, 4},
      {"DOUBLE", real, 1, 8},
      {"VECTOR3D", vector3, 3, 24},
      {"VECTOR6D", vector6, 6, 48},
      {"VECTOR6INT32", vector6_int32, 6, 24},
      {"VECTOR6UINT32", vector6_uint32, 6, 24}};
  for (const auto& [name, type, numbers, size] : types) {
    EXPECT_EQ(rtde_field_type_called(name), type) << name;
    EXPECT_EQ(name_of(type), name);
    EXPECT_EQ(numbers_in(type), numbers) << name;
    EXPECT_EQ(bytes_of(type), size) << name;
  }
  EXPECT_FALSE(rtde_field_type_called("NOT_FOUND").has_value());
  EXPECT_FALSE(rtde_field_type_called("IN_USE").has_value());
  EXPECT_FALSE(rtde_field_type_called("").has_value());
}

TEST(RtdeProtocol, NamesTheColumnsOfVectors) {
  const RtdeRecipe recipe{.id = 1, .fields = {{"timestamp", RtdeFieldType::real}, {"acceleration", RtdeFieldType::vector3}}};
  EXPECT_EQ(columns_of(recipe), (std::vector<std::string>{"timestamp", "acceleration_0", "acceleration_1", "acceleration_2"}));
}

TEST(RtdeProtocol, ReadsBackWhatItWrites) {
  EXPECT_EQ(protocol_version_in(payload_of(rtde_protocol_version_request(2))), 2);
  EXPECT_TRUE(accepted_in(payload_of(rtde_accepted_reply(RtdePackageType::start, true))));
  EXPECT_FALSE(accepted_in(payload_of(rtde_accepted_reply(RtdePackageType::start, false))));
  EXPECT_EQ(text_of(controller_version_in(payload_of(rtde_controller_version_reply({3, 15, 8, 106'339})))), "3.15.8.106339");
  const auto request = outputs_request_in(payload_of(rtde_setup_outputs_request({500, {"timestamp", "actual_q"}})));
  EXPECT_EQ(request.frequency_hz, 500.0);
  EXPECT_EQ(request.names, (std::vector<std::string>{"timestamp", "actual_q"}));
  EXPECT_EQ(outputs_request_in(bytes({0x40, 0x5F, 0x40, 0, 0, 0, 0, 0, 'a', ','})).names, std::vector<std::string>{"a"})
      << "ur_rtde ends its list so";
  const auto reply = setup_reply_in(payload_of(rtde_setup_reply(RtdePackageType::setup_outputs, {9, {"DOUBLE", "NOT_FOUND"}})));
  EXPECT_EQ(reply.recipe_id, 9);
  EXPECT_EQ(reply.types, (std::vector<std::string>{"DOUBLE", "NOT_FOUND"}));
  const auto text = text_in(payload_of(rtde_text_message({"joint 3 is warm", "RTDE", 2})));
  EXPECT_EQ(text.text, "joint 3 is warm");
  EXPECT_EQ(text.source, "RTDE");
  EXPECT_EQ(text.level, 2);
}

TEST(RtdeProtocol, CutsALongTextAtItsGreatestLength) {
  EXPECT_EQ(text_in(payload_of(rtde_text_message({std::string(1'000, 'x'), "y", 0}))).text.size(), 255U);
}

TEST(RtdeProtocol, RefusesNamesThatCannotBeAskedFor) {
  EXPECT_NE(complaint_of([] {
              rtde_setup_outputs_request({125, {std::string(2'000, 'x'), std::string(50, 'y')}});
            }).find("2051 bytes"),
            std::string::npos);
  EXPECT_NE(complaint_of([] { rtde_setup_outputs_request({125, {"a,b"}}); }).find("'a,b'"), std::string::npos);
  EXPECT_NE(complaint_of([] { rtde_setup_outputs_request({125, {""}}); }).find("''"), std::string::npos);
}

TEST(RtdeProtocol, RefusesPayloadsOfAnotherSize) {
  EXPECT_THROW(protocol_version_in(bytes({2})), Error);
  EXPECT_THROW(accepted_in({}), Error);
  EXPECT_THROW(accepted_in(bytes({1, 1})), Error);
  EXPECT_THROW(controller_version_in(Bytes(15)), Error);
  EXPECT_THROW(controller_version_in(Bytes(17)), Error);
  EXPECT_THROW(outputs_request_in(Bytes(7)), Error);
  EXPECT_THROW(setup_reply_in({}), Error);
  EXPECT_THROW(text_in(bytes({5, 'a'})), Error);
  EXPECT_THROW(text_in(bytes({1, 'a', 200, 'b'})), Error);
  EXPECT_THROW(text_in(bytes({1, 'a', 1, 'b'})), Error);
  EXPECT_THROW(text_in(bytes({1, 'a', 1, 'b', 0, 0})), Error);
  const RtdeRecipe recipe{.id = 1, .fields = {{"speed", RtdeFieldType::vector6}}};
  std::vector<RtdeNumber> numbers;
  EXPECT_THROW(read_rtde_data(recipe, Bytes(48, std::byte{1}), numbers), Error);
  EXPECT_THROW(read_rtde_data(recipe, Bytes(50, std::byte{1}), numbers), Error);
  EXPECT_THROW(read_rtde_data(recipe, {}, numbers), Error);
  EXPECT_TRUE(read_rtde_data(recipe, Bytes(49, std::byte{1}), numbers));
  EXPECT_FALSE(read_rtde_data(recipe, Bytes(49, std::byte{2}), numbers)) << "another recipe's data";
}

/// What a reassembly makes of `stream` when it comes in these pieces.
std::vector<std::pair<RtdePackageType, Bytes>> packages_of(const Bytes& stream, const std::function<std::size_t()>& piece) {
  RtdeReassembly reassembly;
  std::vector<std::pair<RtdePackageType, Bytes>> packages;
  for (std::size_t begin = 0; begin < stream.size();) {
    const std::size_t size = std::min(piece(), stream.size() - begin);
    reassembly.append(std::span<const std::byte>(stream).subspan(begin, size));
    while (const auto package = reassembly.next())
      packages.emplace_back(package->type, Bytes(package->payload.begin(), package->payload.end()));
    begin += size;
  }
  return packages;
}

TEST(RtdeReassembly, FindsTheSamePackagesHoweverTheStreamIsCut) {
  const Bytes stream = test::fake_session(20);
  const auto whole = packages_of(stream, [&] { return stream.size(); });
  ASSERT_EQ(whole.size(), 25U);
  EXPECT_EQ(whole[0].first, RtdePackageType::protocol_version);
  EXPECT_EQ(whole[3].first, RtdePackageType::text);
  EXPECT_EQ(whole[24].first, RtdePackageType::data);
  EXPECT_EQ(packages_of(stream, [] { return std::size_t{1}; }), whole);
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    EXPECT_EQ(packages_of(stream, [&] { return 1 + random.below(300); }), whole) << "seed " << seed;
  }
}

TEST(RtdeReassembly, KeepsHalfAPackageForLater) {
  RtdeReassembly reassembly;
  reassembly.append(bytes({0, 4, 0x53}));
  EXPECT_FALSE(reassembly.next().has_value());
  reassembly.append(bytes({1, 0, 3}));
  const auto package = reassembly.next();
  ASSERT_TRUE(package.has_value());
  EXPECT_EQ(package->type, RtdePackageType::start);
  EXPECT_FALSE(reassembly.next().has_value());
}

TEST(RtdeReassembly, RefusesWhatIsNoPackageAsSoonAsItShows) {
  for (const int size : {0, 1, 2}) {
    RtdeReassembly reassembly;
    reassembly.append(bytes({0, size}));
    EXPECT_NE(complaint_of([&] { reassembly.next(); }).find("package of " + std::to_string(size) + " bytes"), std::string::npos);
  }
  RtdeReassembly web_server;
  for (const char c : std::string("HTTP/1.1 400 Bad Request\r\n")) web_server.append(bytes({c}));
  EXPECT_NE(complaint_of([&] { web_server.next(); }).find("type 84"), std::string::npos);
}

}  // namespace
}  // namespace tactile::robot
