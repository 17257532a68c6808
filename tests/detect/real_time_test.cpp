#include "tactile/detect/real_time.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdint>
#include <fstream>

namespace tactile::detect {
namespace {

TEST(AwakeProcessors, ReportWhyTheyMaySleep) {
  const bool permitted = ::access("/dev/cpu_dma_latency", W_OK) == 0;
  const AwakeProcessors first, second;  // several may ask for it at the same time
  EXPECT_EQ(first.refused().empty(), permitted) << first.refused();
  EXPECT_EQ(second.refused().empty(), permitted) << second.refused();
  if (!permitted) {
    EXPECT_NE(first.refused().find("/dev/cpu_dma_latency"), std::string::npos) << first.refused();
    return;
  }
  std::ifstream device("/dev/cpu_dma_latency", std::ios::binary);
  std::int32_t longest_us = -1;
  if (device.read(reinterpret_cast<char*>(&longest_us), sizeof longest_us)) {
    EXPECT_EQ(longest_us, 0) << "asked for as long as they live";
  }
}

}  // namespace
}  // namespace tactile::detect
