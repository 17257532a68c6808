#include "tactile/capture/file_source.hpp"

#include <algorithm>
#include <cassert>
#include <iterator>

#include "tactile/capture/camera_streams.hpp"
#include "tactile/capture/pace.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/simulated_recording.hpp"

namespace tactile::capture {
namespace {

namespace fs = std::filesystem;

/// The rest of a packet that is longer than `packet_span`.
template <class T>
struct Rest {
  std::vector<T> elements;
  std::size_t next = 0;

  bool empty() const { return next == elements.size(); }

  /// Moves the next `span` of it into `piece`.
  void take(std::vector<T>& piece, microseconds span) {
    const auto begin = elements.begin() + static_cast<std::ptrdiff_t>(next);
    const CameraTime end = after(begin->t, span);
    auto last = std::partition_point(begin, elements.end(), [&](const T& element) { return element.t < end; });
    if (last == begin) ++last;  // at the end of the clock
    piece.assign(begin, last);
    next = static_cast<std::size_t>(last - elements.begin());
  }
};

/// One stream's packets, in file order.
struct Lane {
  events::Stream stream;
  std::vector<events::PacketRecord> packets;
  std::size_t next = 0;
  Rest<events::Event> events;
  Rest<events::ImuSample> imu;
  Rest<events::Trigger> triggers;
  AscendingTimes times;

  bool has_rest() const { return !events.empty() || !imu.empty() || !triggers.empty(); }
  bool ended() const { return !has_rest() && next == packets.size(); }
  CameraTime time() const {
    if (!events.empty()) return events.elements[events.next].t;
    if (!imu.empty()) return imu.elements[imu.next].t;
    if (!triggers.empty()) return triggers.elements[triggers.next].t;
    return packets[next].elements == 0 ? CameraTime::min() : packets[next].first;  // an unreadable packet is skipped at once
  }
};

template <class T>
void cut(std::vector<T>& elements, Rest<T>& rest, microseconds span) {
  if (elements.empty() || between(elements.front().t, elements.back().t) < span) return;
  rest.elements.swap(elements);
  rest.next = 0;
  rest.take(elements, span);
}

CameraTime last_time(const CameraPacket& packet) {
  if (!packet.events.empty()) return packet.events.back().t;
  if (!packet.imu.empty()) return packet.imu.back().t;
  if (!packet.triggers.empty()) return packet.triggers.back().t;
  return packet.frame ? packet.frame->t : CameraTime{};
}

/// `run.json` next to a recording; an empty object if there is none, or it cannot be read.
nlohmann::json run_info_beside(const fs::path& file) {
  const fs::path info = file.parent_path() / "run.json";
  if (file.filename() != "events.aedat4" || !fs::exists(info)) return nlohmann::json::object();
  try {
    nlohmann::json json = read_json(info);
    return json.is_object() ? json : nlohmann::json::object();
  } catch (const Error&) {
    return nlohmann::json::object();
  }
}

/// What a recording lacks, according to its list of packets.
std::vector<std::string> lacks_of(const events::RecordingReader& reader) {
  const events::RecordingProblems& problems = reader.problems();
  std::vector<std::string> lacks;
  const auto add = [&lacks](std::uint64_t n, const char* thing, const char* what) {
    if (n > 0) lacks.push_back(std::to_string(n) + " " + thing + (n == 1 ? " " : "s ") + what);
  };
  add(problems.truncated_bytes, "byte", "after the last whole packet are lost: the recording was cut off");
  add(problems.skipped_bytes, "byte", "between packets are damaged and lost");
  add(problems.missing_packets, "packet", "of the data table are missing");
  if (lacks.empty() && !problems.table.empty()) lacks.push_back("the data table cannot be used: " + problems.table);
  if (lacks.empty() && reader.index() == events::PacketIndex::scan)
    lacks.emplace_back("was not closed: its end may be missing, but all its packets are whole");
  return lacks;
}

class FileSource final : public CameraSource {
 public:
  FileSource(std::string name, const fs::path& file, const CameraSourceOptions& options)
      : name_(std::move(name)), reader_(file), pace_(options.speed), live_(options.speed > 0), span_(options.packet_span) {
    const events::Stream& events = events::event_stream(reader_, options.stream);
    for (const events::Stream& stream : reader_.streams()) {
      if (stream.type == events::StreamType::other || stream.source != events.source) continue;
      streams_.push_back(completed(stream));
    }
    for (const events::Stream& stream : streams_) {
      Lane& lane = lanes_.emplace_back();
      lane.stream = stream;
      for (const events::PacketRecord& packet : reader_.packets()) {
        if (packet.stream_id != stream.id) continue;
        lane.packets.push_back(packet);
        if (packet.elements > 0 && (!first_ || packet.first < *first_)) first_ = packet.first;
      }
    }
    const nlohmann::json info = run_info_beside(file);
    simulated_ = events::is_simulated(streams_) || (info.contains("simulated") && info.at("simulated") == true);
    if (info.contains("camera") && info.at("camera").is_object()) camera_ = info.at("camera");
    camera_.update(camera_json(streams_));
    camera_["replay_of"] = file.string();
    std::vector<std::string> lacks = lacks_of(reader_);
    if (info.contains("complete") && info.at("complete") == false)
      lacks.emplace_back("run.json says that the run was not completed");
    for (const std::string& lack : lacks) remark_ += (remark_.empty() ? "" : "; ") + lack;
  }

  std::string name() const override { return name_; }
  std::span<const events::Stream> streams() const override { return streams_; }
  bool simulated() const override { return simulated_; }
  bool live() const override { return live_; }
  bool is_replay() const override { return true; }
  nlohmann::json camera() const override { return camera_; }

  std::string remark() const override { return remark_; }

  Received receive(CameraPacket& packet, std::chrono::microseconds patience) override {
    if (!pace_.has_begun()) pace_.begin(first_.value_or(CameraTime{}));
    while (next_.empty()) {
      if (!read_next()) return Received::ended;
    }
    if (!pace_.wait_for(last_time(next_), patience)) return Received::nothing;
    std::swap(packet, next_);
    next_.clear();
    return Received::packet;
  }

  SourceDrops drops() const override {
    const events::RecordingProblems& problems = reader_.problems();
    SourceDrops drops = backward_;
    drops.packets += problems.broken_packets + problems.mismatched_packets;
    drops.events += problems.out_of_range_events;
    return drops;
  }

 private:
  /// Puts the earliest packet, or its first `span_`, into `next_`, which may stay empty. False if there is none left.
  bool read_next() {
    Lane* lane = nullptr;
    for (Lane& candidate : lanes_) {
      if (!candidate.ended() && (lane == nullptr || candidate.time() < lane->time())) lane = &candidate;
    }
    if (lane == nullptr) return false;
    next_.stream_id = lane->stream.id;
    if (lane->has_rest()) {
      if (!lane->events.empty()) lane->events.take(next_.events, span_);
      if (!lane->imu.empty()) lane->imu.take(next_.imu, span_);
      if (!lane->triggers.empty()) lane->triggers.take(next_.triggers, span_);
      return true;
    }
    const events::PacketRecord& packet = lane->packets[lane->next++];
    switch (lane->stream.type) {
      case events::StreamType::events: {
        const std::span<const events::Event> events = reader_.read_events(packet);
        next_.events.assign(events.begin(), events.end());
        break;
      }
      case events::StreamType::imu:
        next_.imu = reader_.read_imu(packet);
        break;
      case events::StreamType::triggers:
        next_.triggers = reader_.read_triggers(packet);
        break;
      case events::StreamType::frames:
        next_.frame = reader_.read_frame(packet);
        break;
      case events::StreamType::other:
        assert(false && "streams of other types have no lane");
    }
    lane->times.keep(next_, name_, backward_);
    cut(next_.events, lane->events, span_);
    cut(next_.imu, lane->imu, span_);
    cut(next_.triggers, lane->triggers, span_);
    return true;
  }

  std::string name_;
  events::RecordingReader reader_;
  Pace pace_;
  bool live_;
  microseconds span_;  ///< longest time within a packet
  std::vector<events::Stream> streams_;
  std::vector<Lane> lanes_;
  std::optional<CameraTime> first_;
  CameraPacket next_;     ///< waits until it is due
  SourceDrops backward_;  ///< elements back in time
  bool simulated_ = false;
  std::string remark_;
  nlohmann::json camera_ = nlohmann::json::object();
};

}  // namespace

std::unique_ptr<CameraSource> open_file_source(std::string name, const fs::path& path, const CameraSourceOptions& options) {
  const fs::path file = fs::is_directory(path) ? recording_in(path) : path;
  if (!fs::is_regular_file(file))
    throw Error(name + ": there is no " + file.string() + "; expected an AEDAT4 or RAW file, or a run's folder");
  return std::make_unique<FileSource>(std::move(name), file, options);
}

}  // namespace tactile::capture
