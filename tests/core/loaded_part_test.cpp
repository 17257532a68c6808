#include "tactile/core/loaded_part.hpp"

#include <gtest/gtest.h>

#include <string>

#include "support/error_of.hpp"

namespace tactile {
namespace {

TEST(LoadPart, SaysWhichPartIsMissingAndWhereItIsExpected) {
  const std::string error = test::error_of([] { load_part("tactile-nothing.so", "nothing", 1); });
  EXPECT_NE(error.find("/tactile-nothing.so: cannot be loaded ("), std::string::npos) << error;
  EXPECT_NE(error.find("expected this part of tactile in the folder of the program, and enough memory"), std::string::npos)
      << error;
}

}  // namespace
}  // namespace tactile
