#include "tactile/conversion/imported_files.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <iterator>

#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/robot/robot_log.hpp"
#include "tactile/robot/rotation.hpp"
#include "tactile/video/film_picture.hpp"
#include "tactile/video/filmed_times.hpp"

namespace tactile::conversion {
namespace fs = std::filesystem;
namespace {

constexpr microseconds sorted_span{20'000};                 // messages of several threads overlap by less than this
constexpr std::size_t most_waiting = std::size_t{4} << 20;  // events; those of a faster camera are sorted over less time

bool is_of_an_arm(const ToolPose& pose) {
  return std::all_of(pose.place.begin(), pose.place.end(), [](double along) { return std::abs(along) < robot::beyond_any_arm; });
}

/// The mean speed over several steps is at most the highest speed of a step.
bool is_reached(const ToolPose& before, const ToolPose& after) {
  const double most = robot::beyond_any_arm * 1e-6 * static_cast<double>((after.t - before.t).count());
  const std::array<double, 3> turn = robot::turn_from_to(before.turn, after.turn);
  for (std::size_t i = 0; i < 3; ++i) {
    if (std::abs(after.place.at(i) - before.place.at(i)) >= most) return false;
  }
  return std::hypot(turn[0], turn[1], turn[2]) < most;
}

std::string robot_log_header(bool has_joints, bool has_poses) {
  std::string text = "timestamp";
  const auto add_six = [&](std::string_view name) {
    for (int i = 0; i < 6; ++i) text += fmt::format(",{}_{}", name, i);
  };
  if (has_joints) add_six("actual_q");
  if (has_poses) add_six("actual_TCP_pose");
  if (has_poses) add_six("actual_TCP_speed");
  return text + ",host_time_us";
}

video::VideoWriterOptions options_for(cv::Size size) {
  video::VideoWriterOptions options;
  options.width = video::film_size(size).width;
  options.height = video::film_size(size).height;
  return options;
}

}  // namespace

LineFile::LineFile(const fs::path& file, std::string_view header)
    : name_(file.string()), file_(std::fopen(file.c_str(), "wbxe")) {
  if (!file_) throw Error(name_ + ": cannot be made (" + std::strerror(errno) + "); expected a writable folder");
  write(std::string(header) + "\n");
}

void LineFile::write(const std::string& line) {
  if (std::fwrite(line.data(), 1, line.size(), file_.get()) != line.size()) fail();
}

void LineFile::close() {
  if (std::fclose(file_.release()) != 0) fail();
  sync_to_disk(name_);
}

void LineFile::fail() const {
  throw Error(name_ + ": cannot be written (" + std::strerror(errno) + "); expected a place with room");
}

void EventSorter::add(std::span<const events::Event> events) {
  for (const events::Event& event : events) {
    if (count_ > 0 && event.t < last_) {
      ++late_;
      continue;
    }
    if (!waiting_.empty() && event.t < waiting_.back().t) {
      ++sorted_;
      is_sorted_ = false;
    }
    newest_ = waiting_.empty() && count_ == 0 ? event.t : std::max(newest_, event.t);
    waiting_.push_back(event);
  }
  put(waiting_.size() > most_waiting ? CameraTime::max() : before(newest_, sorted_span));
}

void EventSorter::finish() { put(CameraTime::max()); }

void EventSorter::put(CameraTime until) {
  if (waiting_.empty()) return;
  if (!is_sorted_)
    std::stable_sort(waiting_.begin(), waiting_.end(), [](const events::Event& a, const events::Event& b) { return a.t < b.t; });
  is_sorted_ = true;
  const auto end = std::partition_point(waiting_.begin(), waiting_.end(), [&](const events::Event& e) { return e.t <= until; });
  if (end == waiting_.begin()) return;
  if (count_ == 0) first_ = waiting_.front().t;
  last_ = std::prev(end)->t;
  count_ += static_cast<std::uint64_t>(end - waiting_.begin());
  writer_.write_events(stream_id_, {waiting_.begin(), end});
  waiting_.erase(waiting_.begin(), end);
}

ImportedRobotLog::ImportedRobotLog(const fs::path& file, std::optional<JointPositions> joints, bool has_poses)
    : joints_(joints), file_(file, robot_log_header(joints.has_value(), has_poses)) {}

void ImportedRobotLog::set(const JointPositions& joints) {
  for (std::size_t i = 0; joints_ && i < joints.size(); ++i) {
    if (joints.at(i)) joints_->at(i) = joints.at(i);
  }
}

bool ImportedRobotLog::add(const ToolPose& pose, HostTime received) {
  if (!is_of_an_arm(pose) || (current_ && (pose.t <= current_->pose.t || !is_reached(current_->pose, pose)))) return false;
  if (current_) write(*current_, previous_ ? previous_->pose : current_->pose, pose);
  previous_ = current_;
  current_ = Row{pose, received, joints_.value_or(JointPositions{})};
  ++rows_;
  return true;
}

bool ImportedRobotLog::add(HostTime t, HostTime received) {
  if (newest_ && t <= *newest_) return false;
  newest_ = t;
  file_.write(first_cells(t, *joints_) + fmt::format(",{}\n", us_of(received)));
  ++rows_;
  return true;
}

std::string ImportedRobotLog::first_cells(HostTime t, const JointPositions& joints) const {
  std::string cells = fmt::format("{}.{:06}", us_of(t) / 1'000'000, us_of(t) % 1'000'000);
  for (std::size_t i = 0; joints_ && i < joints.size(); ++i) cells += fmt::format(",{}", joints.at(i).value_or(0));
  return cells;
}

void ImportedRobotLog::close() {
  if (current_) write(*current_, previous_ ? previous_->pose : current_->pose, current_->pose);
  file_.close();
}

void ImportedRobotLog::write(const Row& row, const ToolPose& before, const ToolPose& after) {
  std::string line = first_cells(row.pose.t, row.joints);
  const auto add = [&](const auto& values) {
    for (const double value : values) line += fmt::format(",{}", value);
  };
  add(row.pose.place);
  add(robot::rotation_vector_of(row.pose.turn));
  // Between the neighbours: `set_speeds_from_poses` needs rows still to come.
  const double seconds = 1e-6 * static_cast<double>((after.t - before.t).count());
  std::array<double, 3> velocity{}, turning{};
  if (seconds > 0) {
    turning = robot::turn_from_to(before.turn, after.turn);
    for (std::size_t i = 0; i < 3; ++i) {
      velocity.at(i) = (after.place.at(i) - before.place.at(i)) / seconds;
      turning.at(i) /= seconds;
    }
  }
  add(velocity);
  add(turning);
  file_.write(line + fmt::format(",{}\n", us_of(row.received)));
}

ImportedFilm::ImportedFilm(const RunFolder& run, events::SensorSize size)
    : size_(size.width, size.height),
      file_(run.video()),
      times_(run.video_times(), video::filmed_columns),
      writer_(file_, options_for(size_)) {}

bool ImportedFilm::add(const RosImage& image, HostTime received) {
  if (image.pixels.size() != size_) return false;
  if (first_ && image.t <= last_) return false;
  if (!first_) first_ = image.t;
  last_ = image.t;
  const auto pts = VideoTime{image.t - *first_};
  writer_.write(video::film_picture(image.pixels, size_), pts);
  times_.write(video::filmed_row(frames_++, pts, received));
  return true;
}

void ImportedFilm::close() {
  writer_.close();
  sync_to_disk(file_);
  times_.close();
}

}  // namespace tactile::conversion
