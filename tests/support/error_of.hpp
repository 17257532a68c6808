#pragma once

#include <gtest/gtest.h>

#include <string>

#include "tactile/core/error.hpp"

namespace tactile::test {

/// What the `Error` says that `action` throws; a failure if it throws none.
template <class Action>
std::string error_of(const Action& action) {
  try {
    action();
  } catch (const Error& e) {
    return e.what();
  }
  ADD_FAILURE() << "no error";
  return {};
}

}  // namespace tactile::test
