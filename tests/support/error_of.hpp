#pragma once

#include <gtest/gtest.h>

#include <string>

#include "tactile/core/error.hpp"

namespace tactile::test {

/// The message of the `Error` that `action` throws. The test fails if it throws none.
template <class Action>
std::string error_of(const Action& action) {
  try {
    action();
  } catch (const Error& e) {
    return e.what();
  }
  ADD_FAILURE() << "no Error was thrown";
  return {};
}

}  // namespace tactile::test
