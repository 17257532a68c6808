#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bag_recording.hpp"
#include "command.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/core/ticks.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/labels/labels.hpp"
#include "tactile/pictures/event_curve.hpp"

namespace tactile::cli {

/// A recording to look at, read through once: what it spans, how many events it holds and when, and what its run's labels say.
class ViewedRecording {
 public:
  /// @param what    a recording, a bag, or a run's folder
  /// @param stream  as `event_stream` takes it
  /// @throws Error  if there is no such stream, it declares no size, or holds no event
  ViewedRecording(const std::string& what, const std::string& stream, const CommonArguments& common);

  events::RecordingReader& reader() { return reader_; }
  std::int32_t stream_id() const { return stream_id_; }
  events::SensorSize sensor() const { return sensor_; }
  const std::string& name() const { return name_; }  ///< "fan/01", or the file's
  std::string title() const { return name_ + (simulated_ ? " (simulated)" : ""); }
  std::string camera() const;     ///< its name where the recording has it, and the sensor's size
  std::string file_stem() const;  ///< for what is made of it: "fan-01"
  bool simulated() const { return simulated_; }
  CameraTime first() const { return first_; }
  CameraTime last() const { return last_; }
  std::uint64_t events() const { return events_; }
  const pictures::EventCurve& curve() const { return *curve_; }
  bool labelled() const { return labelled_; }
  const std::vector<TouchInterval>& intervals() const { return intervals_; }  ///< by start; none without labels

  double ms_from_first(CameraTime t) const;
  std::optional<Touch> touch_at(CameraTime t) const;  ///< nothing without labels
  /// @throws Error  if the recording holds no full history
  TickRange ticks(const heatmaps::HeatmapOptions& options) const;
  /// The ticks of `ticks` between two times [ms from the first event], by default all.
  /// @throws Error  if there are none, naming the option that is wrong
  TickRange ticks_between(const heatmaps::HeatmapOptions& options, std::optional<double> from_ms,
                          std::optional<double> to_ms) const;

  nlohmann::json json() const;  ///< the part of every result about the recording

 private:
  std::unique_ptr<BagRecording> from_bag_;
  std::optional<RunFolder> run_;
  events::RecordingReader reader_;
  std::string file_;  ///< as a person knows it: of a bag, the bag
  std::int32_t stream_id_ = 0;
  std::string source_;
  events::SensorSize sensor_;
  std::string name_;
  std::string stem_;
  bool simulated_ = false;
  bool labelled_ = false;
  std::vector<TouchInterval> intervals_;
  CameraTime first_{}, last_{};
  std::uint64_t events_ = 0;
  std::optional<pictures::EventCurve> curve_;
};

}  // namespace tactile::cli
