#include "tactile/detect/udp_records.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstring>

namespace tactile::detect {
namespace {

ReportedTick made_tick() {
  ReportedTick tick;
  tick.verdict = {.t = camera_time(-123'456'000),
                  .events = 70'000,
                  .probabilities = {0.25F, 0.5F, 0.125F},
                  .predicted = Touch::press,
                  .verdict = Touch::slip};
  tick.due = {.t = tick.verdict.t, .skipped = 3, .closed = HostTime{microseconds{1'000}}, .by_events = false};
  tick.number = 9;
  tick.beginning = 2;
  tick.incomplete = true;
  return tick;
}

template <class Number>
Number at(const VerdictRecord& record, std::size_t place) {
  Number number{};
  std::memcpy(&number, record.data() + place, sizeof number);
  return number;
}

TEST(UdpRecords, AreAsTheTableInFormatHasThem) {
  const VerdictRecord record = verdict_record(made_tick(), HostTime{microseconds{1'250}});
  EXPECT_EQ(std::memcmp(record.data(), "TACV", 4), 0);
  EXPECT_EQ(at<std::uint16_t>(record, 4), 1);
  EXPECT_EQ(at<std::uint16_t>(record, 6), 64);
  EXPECT_EQ(at<std::uint64_t>(record, 8), 9U);
  EXPECT_EQ(at<std::int64_t>(record, 16), -123'456'000);
  EXPECT_EQ(at<std::int64_t>(record, 24), 1'250);
  EXPECT_EQ(at<float>(record, 32), 0.25F);
  EXPECT_EQ(at<float>(record, 36), 0.5F);
  EXPECT_EQ(at<float>(record, 40), 0.125F);
  EXPECT_EQ(at<std::uint32_t>(record, 44), 70'000U);
  EXPECT_EQ(at<std::uint32_t>(record, 48), 250U);
  EXPECT_EQ(at<std::uint32_t>(record, 52), 3U);
  EXPECT_EQ(at<std::uint32_t>(record, 56), 2U);
  EXPECT_EQ(at<std::uint8_t>(record, 60), 2);
  EXPECT_EQ(at<std::uint8_t>(record, 61), 1);
  EXPECT_EQ(at<std::uint8_t>(record, 62), 2 | 4);
  EXPECT_EQ(at<std::uint8_t>(record, 63), 0);
}

TEST(UdpRecords, HaveOneBitForEachPropertyOfATick) {
  for (const int bits : {0, 2, 4, 6, 8, 14}) {
    ReportedTick tick = made_tick();
    tick.due.by_events = (bits & 2) == 0;
    tick.incomplete = (bits & 4) != 0;
    tick.verdict.slip_is_confirmed = (bits & 8) != 0;
    EXPECT_EQ(at<std::uint8_t>(verdict_record(tick, HostTime{microseconds{1'250}}), 62), bits);
  }
}

TEST(UdpRecords, HoldCountsThatDoNotFit) {
  ReportedTick tick = made_tick();
  tick.verdict.events = std::uint64_t{1} << 40;
  tick.due.skipped = std::uint64_t{1} << 40;
  const VerdictRecord record = verdict_record(tick, HostTime{microseconds{500}});
  EXPECT_EQ(at<std::uint32_t>(record, 44), 0xFFFF'FFFFU);
  EXPECT_EQ(at<std::uint32_t>(record, 48), 0U) << "reported before it closed";
  EXPECT_EQ(at<std::uint32_t>(record, 52), 0xFFFF'FFFFU);
}

TEST(UdpRecords, ArriveOneDatagramEachAndNeverWait) {
  const int receiver = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof address;
  ASSERT_EQ(::bind(receiver, reinterpret_cast<sockaddr*>(&address), length), 0);
  ASSERT_EQ(::getsockname(receiver, reinterpret_cast<sockaddr*>(&address), &length), 0);
  UdpRecords records(
      {.kind = transport::NetworkAddress::Kind::tcp, .host = "127.0.0.1", .port = ntohs(address.sin_port), .path = {}});
  records.send(made_tick());
  VerdictRecord got{};
  std::array<std::byte, 100> larger{};
  ASSERT_EQ(::recv(receiver, larger.data(), larger.size(), 0), 64);
  std::memcpy(got.data(), larger.data(), got.size());
  EXPECT_EQ(at<std::uint64_t>(got, 8), 9U);
  ::close(receiver);
  bool all_sent = true;
  for (int i = 0; i < 10; ++i) all_sent &= records.send(made_tick());  // nobody is there any more
  EXPECT_EQ(records.sent() + records.failed(), 11U);
  EXPECT_EQ(all_sent, records.failed() == 0);
}

}  // namespace
}  // namespace tactile::detect
