#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace tactile {

/// A text file that grows by rows while it is written: it appears with its header whole, and a thread of its own writes what is
/// appended ten times a second and syncs it every second. Whatever ends it, a kill or a full disk, leaves whole rows, but for the
/// last one after a kill.
class GrowingLog {
 public:
  /// @throws Error  if the file exists or cannot be made
  GrowingLog(const std::filesystem::path& file, std::string_view header);
  ~GrowingLog();  ///< writes what is left
  GrowingLog(const GrowingLog&) = delete;
  GrowingLog& operator=(const GrowingLog&) = delete;

  /// Whole lines, each with its end. Never waits for the disk; does nothing once the log has failed.
  void append(std::string_view lines);

  void close();                ///< writes and syncs what is left. @throws Error if the log failed
  std::uint64_t rows() const;  ///< written, the header and empty lines left out
  std::string error() const;   ///< why nothing more is written; empty while all is well

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile
