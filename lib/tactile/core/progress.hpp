#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace tactile {

/// How far a long step has come.
struct Progress {
  std::uint64_t done = 0;
  std::uint64_t total = 0;  ///< 0 where it is unknown
  std::string what;         ///< what is being done now, "fan/03" or "epoch 2: loss 0.31"
};

/// Receives a long step's progress, from one thread at a time. It may throw to end the step: nothing half-written stays.
using ProgressCallback = std::function<void(const Progress&)>;

/// Calls the callback, if there is one.
inline void report_progress(const ProgressCallback& callback, std::uint64_t done, std::uint64_t total, std::string what) {
  if (callback) callback({done, total, std::move(what)});
}

}  // namespace tactile
