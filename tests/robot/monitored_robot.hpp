#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <sstream>
#include <string>
#include <vector>

#include "robot/fake_controller.hpp"
#include "support/comes_true.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/robot/robot_monitor.hpp"

namespace tactile::test {

/// What the monitor logs, kept over its threads.
class MonitorLog {
 public:
  void operator()(const std::string& text) {
    const std::lock_guard lock(mutex_);
    lines_ += text + "\n";
  }
  bool has(const std::string& words) const {
    const std::lock_guard lock(mutex_);
    return lines_.find(words) != std::string::npos;
  }
  std::string all() const {
    const std::lock_guard lock(mutex_);
    return lines_;
  }

 private:
  mutable std::mutex mutex_;
  std::string lines_;
};

inline robot::RobotMonitorOptions options_for(const FakeController& controller, MonitorLog* messages = nullptr) {
  robot::RobotMonitorOptions options;
  options.host = "127.0.0.1";
  options.port = controller.port();
  options.patience = std::chrono::seconds{30};
  if (messages != nullptr) options.log = [messages](const std::string& text) { (*messages)(text); };
  return options;
}

[[nodiscard]] inline bool has_rows(const robot::RobotMonitor& monitor, std::uint64_t rows) {
  return comes_true([&] { return monitor.state().rows >= rows; });
}

/// A log as columns of text by name; empty lines left out.
inline std::map<std::string, std::vector<std::string>> columns_in(const std::filesystem::path& file) {
  std::istringstream in(read_text(file));
  std::string line, cell;
  std::vector<std::string> names;
  std::map<std::string, std::vector<std::string>> columns;
  while (std::getline(in, line)) {
    if (line.empty()) continue;
    std::istringstream cells(line);
    const bool is_header = names.empty();
    for (std::size_t i = 0; std::getline(cells, cell, ','); ++i) {
      if (is_header) {
        names.push_back(cell);
      } else {
        columns[names.at(i)].push_back(cell);
      }
    }
  }
  return columns;
}

inline std::vector<double> numbers_in_column(const std::filesystem::path& file, const std::string& name) {
  std::vector<double> numbers;
  const auto columns = columns_in(file);
  for (const std::string& cell : columns.at(name)) numbers.push_back(number_in(cell).value());
  return numbers;
}

/// True if the log has exactly what the controller sent from the log's first row to its last.
inline ::testing::AssertionResult has_all_that_was_sent(const std::filesystem::path& file, const FakeController& controller) {
  const std::vector<double> logged = numbers_in_column(file, "timestamp");
  const std::vector<double> sent = controller.sent();
  const auto first = std::find(sent.begin(), sent.end(), logged.front());
  if (first == sent.end()) return ::testing::AssertionFailure() << logged.front() << " was never sent";
  if (static_cast<std::size_t>(sent.end() - first) < logged.size() || !std::equal(logged.begin(), logged.end(), first))
    return ::testing::AssertionFailure() << "the log's " << logged.size() << " rows are not those that were sent";
  return ::testing::AssertionSuccess();
}

inline std::string complaint_of(const std::function<void()>& step) {
  try {
    step();
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

}  // namespace tactile::test
