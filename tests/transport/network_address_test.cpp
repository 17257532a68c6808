#include "tactile/transport/network_address.hpp"

#include <gtest/gtest.h>

#include <string>

#include "tactile/core/error.hpp"

namespace tactile::test {
namespace {

TEST(NetworkAddress, NamesAHostAndAPort) {
  const transport::NetworkAddress address = transport::network_address("tcp://camera-host.local:7777");
  EXPECT_EQ(address.kind, transport::NetworkAddress::Kind::tcp);
  EXPECT_EQ(address.host, "camera-host.local");
  EXPECT_EQ(address.port, 7777);
  EXPECT_EQ(address.text(), "tcp://camera-host.local:7777");
}

TEST(NetworkAddress, HasAnIpv6HostInBrackets) {
  const transport::NetworkAddress address = transport::network_address("tcp://[fe80::1]:65535");
  EXPECT_EQ(address.host, "fe80::1");
  EXPECT_EQ(address.port, 65535);
  EXPECT_EQ(address.text(), "tcp://[fe80::1]:65535");
}

TEST(NetworkAddress, NamesASocketByItsPath) {
  const transport::NetworkAddress address = transport::network_address("unix:/run/events of today");
  EXPECT_EQ(address.kind, transport::NetworkAddress::Kind::unix_socket);
  EXPECT_EQ(address.path, "/run/events of today");
  EXPECT_EQ(address.text(), "unix:/run/events of today");
}

TEST(NetworkAddress, AcceptsAPathOf107BytesAndNoLonger) {
  EXPECT_EQ(transport::network_address("unix:" + std::string(107, 'p')).path.string().size(), 107U);
  EXPECT_THROW(transport::network_address("unix:" + std::string(108, 'p')), Error);
}

TEST(NetworkAddress, RejectsOtherTextsAndExplainsTheForm) {
  for (const std::string text :
       {"", "camera:7777", "http://camera:7777", "tcp://", "tcp://camera", "tcp://camera:", "tcp://:7777", "tcp://camera:0",
        "tcp://camera:65536", "tcp://camera:-1", "tcp://camera:7777/", "tcp://camera:77x", "tcp://cam era:7777", "tcp://::1:7777",
        "tcp://[camera]:7777", "tcp://[::1]", "tcp://[]:7777", "tcp://a/b:1", "unix:"}) {
    try {
      transport::network_address(text);
      ADD_FAILURE() << text << " was taken";
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find("'" + text + "'"), std::string::npos) << e.what();
      EXPECT_NE(std::string(e.what()).find("expected"), std::string::npos) << e.what();
    }
  }
  EXPECT_THROW(transport::network_address(std::string("unix:a\0b", 8)), Error);
}

}  // namespace
}  // namespace tactile::test
