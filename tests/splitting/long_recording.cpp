#include "splitting/long_recording.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <fstream>

#include "support/events_in_file.hpp"
#include "tactile/core/csv.hpp"
#include "tactile/core/truth.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile::test {
namespace fs = std::filesystem;
namespace {

std::vector<events::ImuSample> imu_in(events::RecordingReader& recording) {
  std::vector<events::ImuSample> all;
  for (const events::PacketRecord& packet : recording.packets()) {
    if (recording.stream(packet.stream_id).type != events::StreamType::imu) continue;
    const auto samples = recording.read_imu(packet);
    all.insert(all.end(), samples.begin(), samples.end());
  }
  return all;
}

template <class Element>
std::vector<Element> moved(std::vector<Element> elements, microseconds shift) {
  for (Element& element : elements) element.t = after(element.t, shift);
  return elements;
}

/// Rows of the joined log, each at its time on the robot's clock.
class JoinedLog {
 public:
  explicit JoinedLog(const fs::path& file) : out_(file) {}

  void add(const fs::path& log, const ClockRelation& clock, microseconds shift) {
    const std::string text = read_text(log);
    CsvRows rows(text);
    if (last_.empty()) out_ << rows.row() << '\n';
    while (rows.next_filled()) {
      const std::string_view row = rows.row();
      const std::size_t comma = row.find(',');
      const CameraTime t = after(clock.camera_from(std::llround(1e6 * std::stod(std::string(row.substr(0, comma))))), shift);
      for (CameraTime fill = after(last_at_, 8ms); !last_.empty() && fill < before(t, 8ms); fill = after(fill, 8ms))
        write(fill, last_);
      if (!last_.empty() && t <= last_at_) continue;
      last_ = row.substr(comma);
      last_at_ = t;
      write(t, last_);
    }
  }

 private:
  void write(CameraTime t, const std::string& rest_of_row) {
    out_ << fmt::format("{:.6f}", 1e-6 * static_cast<double>(us_of(t)) + 5.0) << rest_of_row << '\n';
  }

  std::ofstream out_;
  std::string last_;
  CameraTime last_at_{};
};

}  // namespace

LongRecording join_runs(const std::vector<RunFolder>& runs, const fs::path& folder) {
  LongRecording made{.folder = folder};
  fs::create_directories(folder);
  events::RecordingReader model(runs.front().events());
  events::RecordingWriter writer(folder / "events.aedat4", {model.streams().begin(), model.streams().end()});
  JoinedLog log(folder / "robot.csv");
  CameraTime begin = camera_time(1'000'000'000'000);
  const std::int32_t event_stream = events::event_stream(model).id;
  for (const RunFolder& run : runs) {
    const auto events = events_in_file(run.events());
    const microseconds shift = between(events.front().t, begin);
    writer.write_events(event_stream, moved(events, shift));
    events::RecordingReader recording(run.events());
    for (const events::Stream& stream : model.streams()) {
      if (stream.type == events::StreamType::imu) writer.write_imu(stream.id, moved(imu_in(recording), shift));
    }
    const Truth truth = read_truth(run.truth());
    log.add(run.robot(), *truth.robot_clock, shift);
    for (const TrueInterval& interval : truth.intervals) {
      if (!interval.labelled) continue;
      made.touches.push_back({.touch = interval.interval.touch,
                              .start = after(interval.interval.start, shift),
                              .end = after(interval.interval.end, shift)});
    }
    made.run_begins.push_back(begin);
    begin = after(after(events.back().t, shift), 1ms);
  }
  writer.close();
  return made;
}

}  // namespace tactile::test
