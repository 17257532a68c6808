#include "tactile/capture/simulator_source.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tactile/capture/camera_streams.hpp"
#include "tactile/capture/pace.hpp"
#include "tactile/core/error.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/recording_writer.hpp"
#include "tactile/events/simulated_recording.hpp"
#include "tactile/simulation/simulated_run.hpp"

namespace tactile::capture {
namespace {

constexpr std::string_view usual_object = "water-bottle", preset = "quick";
constexpr microseconds packet_span = 1ms;
constexpr microseconds between_recordings = 5s;  ///< on the camera's clock, from the end of one to the start of the next

bool is_model(const std::string& name) {
  const auto& models = simulation::default_physics().objects;
  return std::any_of(models.begin(), models.end(), [&](const simulation::ObjectModel& model) { return model.name == name; });
}

/// The last event of a recording; nothing if it has none or cannot be read.
std::optional<CameraTime> last_event_in(const std::filesystem::path& file) {
  std::optional<CameraTime> last;
  try {
    const events::RecordingReader recording(file);
    for (const events::PacketRecord& packet : recording.packets()) {
      if (packet.elements == 0 || recording.stream(packet.stream_id).type != events::StreamType::events) continue;
      last = std::max(last.value_or(packet.last), packet.last);
    }
  } catch (const Error&) {
    return std::nullopt;
  }
  return last;
}

microseconds readout_of(const simulation::DrawnRun& drawn) {
  return microseconds{std::llround(std::ceil(drawn.camera.readout_us))};
}

/// One simulated run.
struct Scene {
  Scene(simulation::DrawnRun run, const simulation::CameraPixels& pixels)
      : drawn(std::move(run)), film(simulation::film_of(drawn, pixels)), imu(simulation::imu_of(drawn)) {}

  simulation::DrawnRun drawn;
  simulation::SkinFilm film;
  CameraTime last_event{};
  std::vector<events::ImuSample> imu;
  std::size_t felt = 0;  ///< IMU samples that were sent
};

class SimulatorSource final : public CameraSource {
 public:
  SimulatorSource(std::string name, std::optional<std::string> object, double speed, std::uint64_t seed)
      : name_(std::move(name)),
        object_(std::move(object)),
        seed_(seed),
        pace_(speed),
        live_(speed > 0),
        physics_(simulation::default_physics()),
        streams_{events::event_stream_declaration(physics_.camera.size, simulation::simulated_camera_name(seed)),
                 simulation::simulated_imu_stream(simulation::simulated_camera_name(seed))} {
    if (object_) physics_.object(*object_);
    set_info(streams_[0], readout_mode_attribute, std::string(simulation::readout_mode_of(physics_.camera)));
    for (events::Stream& stream : streams_) set_info(stream, events::simulated_attribute, "true");
  }

  std::string name() const override { return name_; }
  std::span<const events::Stream> streams() const override { return streams_; }
  bool simulated() const override { return true; }
  bool live() const override { return live_; }
  bool begins_again() const override { return true; }
  nlohmann::json camera() const override {
    nlohmann::json json = camera_json(streams());
    json["readout_us"] = camera_ ? camera_->options.readout_us : physics_.camera.readout_us;
    json["simulator"] = {{"object", scene_ ? scene_->drawn.object.name : object_.value_or(std::string(usual_object))},
                         {"preset", preset},
                         {"seed", seed_},
                         {"model_version", simulation::simulation_model_version}};
    return json;
  }

  void begin_run(const RunFolder& run) override {
    if (!recorded_) {  // what came before the first run is not kept
      clocks_.reset();
      camera_.reset();
    }
    begin(object_.value_or(is_model(run.object) ? run.object : std::string(usual_object)), run.run, between_recordings);
    recorded_ = run.folder;
    pace_.reset();
  }

  Received receive(CameraPacket& packet, std::chrono::microseconds patience) override {
    while (next_.events.empty() && next_.imu.empty()) {
      if (scene_ && !scene_->film.ended()) {
        film_next();
      } else if (recorded_) {
        return Received::ended;
      } else {
        begin(object_.value_or(std::string(usual_object)), fmt::format("{:02}", ++endless_runs_), {});
      }
    }
    if (!pace_.has_begun()) pace_.begin(scene_->drawn.start());
    if (!pace_.wait_for(scene_->film.filmed().last_readout, patience)) return Received::nothing;
    packet.clear();
    // The earlier packet goes first: a run's duration counts from there.
    const bool events_first = next_.imu.empty() || (!next_.events.empty() && next_.events.front().t <= next_.imu.front().t);
    if (events_first) {
      packet.stream_id = streams_[0].id;
      packet.events.swap(next_.events);
    } else {
      packet.stream_id = streams_[1].id;
      packet.imu.swap(next_.imu);
    }
    return Received::packet;
  }

  SourceDrops drops() const override { return {}; }

  void end_run(const RunFolder& run, bool wants_robot, bool wants_video) override {
    if (!scene_ || recorded_ != run.folder) return;
    const std::optional<CameraTime> last = last_event_in(run.events());
    const bool is_whole = scene_->film.ended() && last && *last >= scene_->last_event;
    std::optional<CameraTime> until;
    if (!is_whole) until = last.value_or(scene_->drawn.start());
    if (wants_robot) simulation::write_robot(run.robot(), scene_->drawn, until);
    if (wants_video) simulation::write_video(run.video(), run.video_times(), scene_->drawn, until);
    Truth truth = simulation::truth_of(scene_->drawn, pixels_, scene_->film.filmed(), until);
    // A real robot or film is not simulated.
    if (!wants_robot) truth.lift_start.reset();
    if (!wants_robot) truth.robot_clock.reset();
    if (!wants_video) truth.video_clock.reset();
    write_truth(run.truth(), truth);
  }

 private:
  void begin(const std::string& object, const std::string& run, microseconds gap) {
    simulation::DrawnRun drawn = simulation::draw_run(physics_, object, run, std::string(preset), seed_, camera_);
    if (clocks_) {
      drawn.clocks =
          simulation::continued_clocks(drawn.clocks, *clocks_, scene_->film.filmed().last_readout + readout_of(drawn) + gap);
    } else {
      clocks_ = drawn.clocks;
    }
    if (!camera_) {
      camera_ = {.options = drawn.camera, .pixels_seed = drawn.pixels_seed};
      pixels_ = simulation::camera_pixels_of(drawn);
    }
    next_.clear();
    scene_ = std::make_unique<Scene>(std::move(drawn), pixels_);
  }

  /// The read-outs of the next millisecond, and further ones until there is an event, with the IMU samples of this time.
  void film_next() {
    const auto readouts = packet_span / readout_of(scene_->drawn);
    for (std::int64_t k = 0; !scene_->film.ended() && (k < readouts || next_.events.empty()); ++k) {
      const std::span<const events::Event> events = scene_->film.next();
      next_.events.insert(next_.events.end(), events.begin(), events.end());
    }
    if (!next_.events.empty()) scene_->last_event = next_.events.back().t;
    std::size_t& felt = scene_->felt;
    for (; felt < scene_->imu.size() && scene_->imu[felt].t <= scene_->film.filmed().last_readout; ++felt)
      next_.imu.push_back(scene_->imu[felt]);
  }

  std::string name_;
  std::optional<std::string> object_;
  std::uint64_t seed_;
  Pace pace_;
  bool live_;
  const simulation::SimulationPhysics& physics_;
  std::optional<simulation::SessionCamera> camera_;  ///< that of the first run: the source is one session
  simulation::CameraPixels pixels_;
  std::array<events::Stream, 2> streams_;        ///< events and IMU samples
  std::optional<simulation::RunClocks> clocks_;  ///< of the first run
  std::unique_ptr<Scene> scene_;
  std::optional<std::filesystem::path> recorded_;  ///< the run being recorded
  int endless_runs_ = 0;
  CameraPacket next_;  ///< waits until it is due
};

}  // namespace

std::unique_ptr<CameraSource> open_simulator_source(std::string name, std::optional<std::string> object, double speed,
                                                    std::uint64_t seed) {
  return std::make_unique<SimulatorSource>(std::move(name), std::move(object), speed, seed);
}

}  // namespace tactile::capture
