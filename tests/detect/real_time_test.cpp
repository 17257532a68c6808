#include "tactile/detect/real_time.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

namespace tactile {
namespace {

TEST(AwakeProcessors, SayWhyTheyMaySleepWhereTheyMay) {
  const bool permitted = ::access("/dev/cpu_dma_latency", W_OK) == 0;
  const AwakeProcessors first, second;  // several may ask for it at the same time
  EXPECT_EQ(first.refused().empty(), permitted) << first.refused();
  EXPECT_EQ(second.refused().empty(), permitted) << second.refused();
  if (!permitted) {
    EXPECT_NE(first.refused().find("/dev/cpu_dma_latency"), std::string::npos) << first.refused();
  }
}

}  // namespace
}  // namespace tactile
