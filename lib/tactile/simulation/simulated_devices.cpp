#include "tactile/simulation/simulated_devices.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace tactile {
namespace {

constexpr std::int64_t robot_period_us = 8000;
constexpr double lost_package_share = 0.004;
constexpr double frame_period_s = 1.0 / 30.0;
constexpr double lost_frame_share = 0.01;
constexpr int video_width = 320, video_height = 240;
constexpr double video_px_per_mm = 1.3;
constexpr std::size_t batch_events = 1 << 15;

double seconds_since_start(CameraTime t, const RunClocks& clocks) {
  return 1e-6 * static_cast<double>(us_of(t) - clocks.camera_start_us);
}

/// As a log prints it: more digits than the encoders know only make files larger.
double rounded(double value) { return std::round(value * 1e7) / 1e7; }

/// A filled rectangle whose sides may lie between pixels.
void fill_box(cv::Mat& frame, double left, double top, double right, double bottom, int grey) {
  constexpr int shift = 6;
  const auto fixed = [](double value) {
    return static_cast<int>(std::lround(std::clamp(value, -1000.0, 2000.0) * (1 << shift)));
  };
  const std::array corners{cv::Point(fixed(left), fixed(top)), cv::Point(fixed(right), fixed(top)),
                           cv::Point(fixed(right), fixed(bottom)), cv::Point(fixed(left), fixed(bottom))};
  cv::fillConvexPoly(frame, corners.data(), static_cast<int>(corners.size()), cv::Scalar(grey), cv::LINE_AA, shift);
}

}  // namespace

SkinFilm::SkinFilm(const SkinMotion& motion, const CameraPixels& pixels, const EventCameraOptions& options, CameraTime start,
                   std::uint64_t seed)
    : motion_(&motion), camera_(pixels, options, start, seed, motion.poses.front()), readout_(options.readout), start_(start) {}

std::span<const Event> SkinFilm::next() {
  const EventCamera::ReadOut seen = camera_.read_out(motion_->poses[next_]);
  const microseconds since = readout_ * static_cast<std::int64_t>(next_);
  ++next_;
  filmed_.last_readout = start_ + since;
  filmed_.events += seen.events.size();
  filmed_.caused += seen.caused;
  if (seen.caused > 0) {
    std::optional<CameraTime>& first = since < motion_->slip_start ? filmed_.first_of_press : filmed_.first_of_slip;
    if (!first) first = filmed_.last_readout;
  }
  return seen.events;
}

void film_whole(SkinFilm& film, const std::function<void(std::span<const Event>)>& use,
                const std::function<void(double)>& tell_share) {
  std::vector<Event> batch;
  for (std::size_t k = 0; !film.ended(); ++k) {
    const double share = film.share_done();
    const std::span<const Event> events = film.next();
    batch.insert(batch.end(), events.begin(), events.end());
    if (batch.size() >= batch_events) {
      use(batch);
      batch.clear();
    }
    if (tell_share && k % 500 == 0) tell_share(share);
  }
  if (!batch.empty()) use(batch);
}

FilmedSkin film_skin(const SkinMotion& motion, const CameraPixels& pixels, const EventCameraOptions& options, CameraTime start,
                     std::uint64_t seed, const std::function<void(std::span<const Event>)>& use,
                     const std::function<void(double)>& tell_share) {
  SkinFilm film(motion, pixels, options, start, seed);
  film_whole(film, use, tell_share);
  return film.filmed();
}

LoggedRobot log_robot(const RunPlan& plan, const RunClocks& clocks, Random& random) {
  const double speed_noise = 1e-3 * random.uniform(0.2, 0.5);  // [m/s]
  std::array<double, 6> place{random.uniform(-0.6, -0.4), random.uniform(0.1, 0.3), random.uniform(0.2, 0.3), 0, 0, 0};
  for (std::size_t i = 3; i < 6; ++i) place[i] = random.uniform(-2.0, 2.0);
  const double end_s = plan.end_s + random.uniform(0.1, 0.6);

  LoggedRobot robot;
  for (std::int64_t k = 0;; ++k) {
    RobotState state;
    state.t = RobotTime{microseconds{clocks.robot.reference_us + k * robot_period_us}};
    const double t_s = seconds_since_start(clocks.robot.camera_from(state.t), clocks);
    if (t_s > end_s) break;
    if (k > 0 && random.uniform() < lost_package_share) {
      ++robot.dropped_packages;
      continue;
    }
    state.tcp_pose = place;
    state.tcp_pose[2] += 1e-3 * plan.lift_travel_at(t_s);
    state.tcp_speed[2] = 1e-3 * plan.lift_speed_at(t_s);
    for (std::size_t i = 0; i < 6; ++i) {
      state.tcp_pose[i] = rounded(state.tcp_pose[i] + 1e-5 * random.normal());
      state.tcp_speed[i] = rounded(state.tcp_speed[i] + (i < 3 ? 1.0 : 3.0) * speed_noise * random.normal());
    }
    state.digital_output_bits = plan.stage_on_robot_output && t_s >= plan.stage_start_s ? 1 : 0;
    robot.log.states.push_back(state);
  }
  return robot;
}

std::vector<VideoTime> draw_frame_times(const RunPlan& plan, const RunClocks& clocks, Random& random) {
  const double period_s = frame_period_s * random.uniform(0.995, 1.005);
  const double end_s = plan.end_s + random.uniform(0.05, 0.3);
  std::vector<VideoTime> times;
  for (double at_s = 0;; at_s += period_s) {
    const double jitter_s = times.empty() ? 0.0 : 8e-4 * std::clamp(random.normal(), -3.0, 3.0);
    const bool lost = !times.empty() && random.uniform() < lost_frame_share;
    const VideoTime t{microseconds{std::llround(1e6 * (at_s + jitter_s))}};
    if (seconds_since_start(clocks.video.camera_from(t), clocks) > end_s) return times;
    if (!lost) times.push_back(t);
  }
}

cv::Mat draw_frame(const ObjectModel& object, const RunPlan& plan, double t_s, Random& random) {
  cv::Mat frame(video_height, video_width, CV_8UC1, cv::Scalar(70));
  const double table = 222, centre = 160;
  fill_box(frame, 0, table, video_width, video_height, 105);
  // The object stands still; the light press does not hold it.
  const double half_width = (object.radius_mm > 0 ? std::min(object.radius_mm, 26.0) : object.half_width_mm) * video_px_per_mm;
  const double height = 2.5 * object.half_height_mm * video_px_per_mm;
  fill_box(frame, centre - half_width, table - height, centre + half_width, table, 170);

  const double lift_px = video_px_per_mm * plan.lift_travel_at(t_s);
  const double full_px = video_px_per_mm * plan.stage_travel_at(plan.contact_s + plan.press_s);
  const double gap_px = full_px - video_px_per_mm * plan.stage_travel_at(t_s);
  const double middle = std::min(table - 0.55 * height, table - 22) - lift_px;  // never in the table
  const double right_of_sensor = centre - half_width - gap_px, left_of_finger = centre + half_width;
  fill_box(frame, centre - 75, middle - 52, centre + 75, middle - 40, 40);               // the gripper's bar
  fill_box(frame, centre - 10, -200, centre + 10, middle - 52, 55);                      // the arm
  fill_box(frame, right_of_sensor - 26, middle - 40, right_of_sensor, middle + 18, 25);  // the sensor on its stage
  fill_box(frame, left_of_finger, middle - 40, left_of_finger + 8, middle + 18, 210);    // the finger that does not move
  for (int row = 0; row < frame.rows; ++row) {
    auto* pixels = frame.ptr<std::uint8_t>(row);
    for (int x = 0; x < frame.cols; x += 8) {
      const std::uint64_t bits = random.bits();
      for (int i = 0; i < 8; ++i) {  // two 3-bit numbers per pixel: about a normal of 2.3 grey levels, for a tenth of its cost
        const auto byte = static_cast<int>(bits >> (8 * i) & 0xFF);
        const int grey = pixels[x + i] + (byte & 7) - (byte >> 3 & 7) - (byte >> 6 & 1) + (byte >> 7 & 1);
        pixels[x + i] = static_cast<std::uint8_t>(std::clamp(grey, 0, 255));
      }
    }
  }
  return frame;
}

}  // namespace tactile
