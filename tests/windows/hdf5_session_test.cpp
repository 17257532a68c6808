#include <gtest/gtest.h>

#include <cstdlib>
#include <exception>
#include <new>

#include "tactile/hdf5/hdf5_objects.hpp"

namespace tactile::hdf5 {
namespace {

constexpr int code_for_lack_of_memory = 42;

[[noreturn]] void end_with_code() {
  try {
    std::rethrow_exception(std::current_exception());
  } catch (const std::bad_alloc&) {
    std::_Exit(code_for_lack_of_memory);
  }
}

TEST(Hdf5SessionDeathTest, AnExitWithinItIsALackOfMemory) {
  const auto exit_within = [] {
    std::set_terminate(end_with_code);
    const Session outer;
    { const Session inner; }
    std::exit(7);
  };
  EXPECT_EXIT(exit_within(), testing::ExitedWithCode(code_for_lack_of_memory), "");
}

TEST(Hdf5SessionDeathTest, AnExitAfterItIsOne) {
  const auto exit_after = [] {
    std::set_terminate(end_with_code);
    { const Session session; }
    std::exit(7);
  };
  EXPECT_EXIT(exit_after(), testing::ExitedWithCode(7), "");
}

}  // namespace
}  // namespace tactile::hdf5
