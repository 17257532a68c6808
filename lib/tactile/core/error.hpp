#pragma once

#include <stdexcept>
#include <string>

namespace tactile {

/// Input that cannot be used. The text is one sentence: which input, what is wrong with it, what would be right.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace tactile
