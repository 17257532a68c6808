#pragma once

#include <fmt/core.h>

#include <cstdio>
#include <iostream>
#include <string>

namespace tactile::bench {

/// Prints "ready", then `answer(line)` for each line of standard input. workers.py starts such programs and measures them in
/// turn.
template <class Answer>
void answer_each_line(const Answer& answer) {
  fmt::print("ready\n");
  std::fflush(stdout);
  for (std::string line; std::getline(std::cin, line);) {
    fmt::print("{}\n", answer(line));
    std::fflush(stdout);
  }
}

}  // namespace tactile::bench
