#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace tactile::robot {

/// A text file that grows by rows. It appears with its whole header. A thread writes appended rows ten times a second and syncs
/// the file every second. A kill or a full disk leaves whole rows, except perhaps the last one after a kill.
class GrowingLog {
 public:
  /// @throws Error  if the file exists or cannot be made
  GrowingLog(const std::filesystem::path& file, std::string_view header);
  ~GrowingLog();  ///< writes what is left
  GrowingLog(const GrowingLog&) = delete;
  GrowingLog& operator=(const GrowingLog&) = delete;

  /// Whole lines, each with its end. Does not wait for the disk; does nothing after a failure.
  void append(std::string_view lines);

  void close();                ///< writes and syncs what is left. @throws Error if the log failed
  std::uint64_t rows() const;  ///< written, without the header and empty lines
  std::string error() const;   ///< why nothing more is written; empty if there is no error

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile::robot
