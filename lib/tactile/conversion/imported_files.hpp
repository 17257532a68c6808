#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/conversion/ros_messages.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/core/time.hpp"
#include "tactile/events/event.hpp"
#include "tactile/events/recording_writer.hpp"
#include "tactile/video/video_writer.hpp"

// The files of a run, written from a bag's messages.
namespace tactile::conversion {

/// A text file written line by line.
class LineFile {
 public:
  /// @throws Error  if it exists or cannot be made
  LineFile(const std::filesystem::path& file, std::string_view header);
  void write(const std::string& line);  ///< with its end
  void close();                         ///< and syncs. @throws Error if that or the writing failed

 private:
  [[noreturn]] void fail() const;

  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::string name_;
  std::unique_ptr<std::FILE, Closer> file_;
};

/// Writes events to a recording in the order of time. It holds every event back until the newest is 20 ms later, for less with a
/// very fast camera. Events that come later than that are dropped and counted.
class EventSorter {
 public:
  EventSorter(events::RecordingWriter& writer, std::int32_t stream_id) : writer_(writer), stream_id_(stream_id) {}

  void add(std::span<const events::Event> events);
  void finish();  ///< writes all waiting events

  std::uint64_t written() const { return count_; }
  std::uint64_t sorted() const { return sorted_; }  ///< events that came out of order
  std::uint64_t late() const { return late_; }      ///< dropped
  CameraTime first() const { return first_; }       ///< of those that are written
  CameraTime last() const { return last_; }

 private:
  void put(CameraTime until);

  events::RecordingWriter& writer_;
  std::int32_t stream_id_;
  std::vector<events::Event> waiting_;
  CameraTime newest_{}, first_{}, last_{};
  std::uint64_t count_ = 0, sorted_ = 0, late_ = 0;
  bool is_sorted_ = true;
};

/// robot.csv. A row is a pose, written when the next one comes, because its speed depends on that pose; or, in a log without
/// poses, the positions of the joints.
class ImportedRobotLog {
 public:
  /// @param joints  the first positions of the joints; nothing if the log has none
  ImportedRobotLog(const std::filesystem::path& file, std::optional<JointPositions> joints, bool has_poses = true);

  void set(const JointPositions& joints);  ///< for the next rows; joints that it does not name keep their positions
  /// Adds a row. @return  false, and the row is omitted, if it is not later than the one before or an arm cannot reach it
  bool add(const ToolPose& pose, HostTime received);
  /// Adds a row of joints to a log without poses. @return  false, and the row is omitted, if it is not later than the one before
  bool add(HostTime t, HostTime received);
  std::uint64_t rows() const { return rows_; }
  void close();

 private:
  struct Row {
    ToolPose pose;
    HostTime received;
    JointPositions joints;
  };
  void write(const Row& row, const ToolPose& before, const ToolPose& after);
  std::string first_cells(HostTime t, const JointPositions& joints) const;  ///< a row's time and joints

  std::optional<JointPositions> joints_;
  LineFile file_;
  std::optional<Row> previous_, current_;
  std::optional<HostTime> newest_;  ///< of a log without poses
  std::uint64_t rows_ = 0;
};

/// video.mp4 and video.csv.
class ImportedFilm {
 public:
  ImportedFilm(const RunFolder& run, events::SensorSize size);

  /// Adds a frame. @return  false, and the frame is omitted, if it has another size or is not later than the one before
  bool add(const RosImage& image, HostTime received);
  std::uint64_t frames() const { return frames_; }
  std::optional<HostTime> first() const { return first_; }  ///< stamp
  void close();

 private:
  cv::Size size_;
  std::filesystem::path file_;
  LineFile times_;
  video::VideoWriter writer_;
  std::optional<HostTime> first_;
  HostTime last_{};
  std::uint64_t frames_ = 0;
};

}  // namespace tactile::conversion
