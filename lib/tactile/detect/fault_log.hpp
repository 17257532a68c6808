#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "tactile/detect/detection_fault.hpp"

namespace tactile::detect {

/// Faults by kind, and the first of them. May be used from several threads.
class FaultLog {
 public:
  static constexpr std::size_t limit = 1'000;  ///< faults that are kept; further ones are only counted

  void add(const DetectionFault& fault) {
    const std::scoped_lock lock(guard_);
    ++kinds_[fault.kind];
    if (first_.size() < limit && !fault.text.empty()) first_.push_back(fault);
  }
  std::map<std::string, std::uint64_t> kinds() const {
    const std::scoped_lock lock(guard_);
    return kinds_;
  }
  std::vector<DetectionFault> first() const {
    const std::scoped_lock lock(guard_);
    return first_;
  }

 private:
  mutable std::mutex guard_;
  std::map<std::string, std::uint64_t> kinds_;
  std::vector<DetectionFault> first_;
};

}  // namespace tactile::detect
