#include "tactile/simulation/simulated_video.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace tactile::simulation {
namespace {

constexpr int width = 320, height = 240;
constexpr std::size_t frame_pixels = std::size_t{width} * height;
constexpr std::size_t noise_pixels = std::size_t{1} << 17;  // frames begin at random places in it, so they differ
constexpr double px_per_mm = 1.3;
constexpr double table_px = 222, centre_px = 160;
constexpr double open_mm = 6;  // travel of a stage that never closes
constexpr double least_exposure = 0.7, most_exposure = 1.4;

struct Box {
  double left, top, right, bottom;
};

/// The share of the pixel from `at` to `at + 1` that lies between the two.
double covered(int at, double from, double to) {
  return std::clamp(std::min(to, at + 1.0) - std::max<double>(from, at), 0.0, 1.0);
}

/// A filled rectangle whose sides may lie between pixels.
void fill_box(cv::Mat& frame, Box box, double grey) {
  box = {std::clamp(box.left, 0.0, double{width}), std::clamp(box.top, 0.0, double{height}),
         std::clamp(box.right, 0.0, double{width}), std::clamp(box.bottom, 0.0, double{height})};
  if (box.left >= box.right || box.top >= box.bottom) return;
  const int first = static_cast<int>(box.left), last = static_cast<int>(std::ceil(box.right)) - 1;
  const auto mix = [&](std::uint8_t& pixel, double share) {
    pixel = static_cast<std::uint8_t>(std::lround(pixel + share * (grey - pixel)));
  };
  for (int y = static_cast<int>(box.top); y < box.bottom; ++y) {
    auto* pixels = frame.ptr<std::uint8_t>(y);
    const double share = covered(y, box.top, box.bottom);
    mix(pixels[first], share * covered(first, box.left, box.right));
    if (last == first) continue;
    if (share == 1.0) {
      std::memset(pixels + first + 1, static_cast<int>(std::lround(grey)), static_cast<std::size_t>(last - first - 1));
    } else {
      for (int x = first + 1; x < last; ++x) mix(pixels[x], share);
    }
    mix(pixels[last], share * covered(last, box.left, box.right));
  }
}

/// Grey noise, cheap: a few thousand normal values in any order.
std::vector<std::int8_t> draw_noise(double sigma, Random& random) {
  constexpr int bits = 12;
  std::array<std::int8_t, 1 << bits> values;
  for (std::int8_t& value : values)
    value = static_cast<std::int8_t>(std::clamp(std::lround(sigma * random.normal()), -127L, 127L));
  std::vector<std::int8_t> noise(noise_pixels);
  std::uint64_t word = 0;
  for (std::size_t i = 0; i < noise.size(); ++i) {
    word = i % (64 / bits) == 0 ? random.bits() : word >> bits;
    noise[i] = values[word & (values.size() - 1)];
  }
  return noise;
}

}  // namespace

SimulatedVideo::SimulatedVideo(const ObjectModel& object, const RunPlan& plan, const RunClocks& clocks,
                               const VideoPhysics& physics, Random random)
    : plan_(&plan),
      clocks_(&clocks),
      half_width_px_((object.radius_mm > 0 ? std::min(object.radius_mm, 26.0) : object.half_width_mm) * px_per_mm),
      height_px_(2.5 * object.half_height_mm * px_per_mm),
      grey_(20 + 250 * object.reflectivity),
      closed_mm_(plan.stage_travel_at(0) + (plan.presses.empty() ? open_mm : 0.0)) {
  for (const PressPlan& press : plan.presses) closed_mm_ = std::max(closed_mm_, plan.stage_travel_at(press.still_s()));

  const double period_s = 1.0 / (physics.rate_hz * (1.0 + random.uniform(-physics.rate_error, physics.rate_error)));
  const double end_s = plan.end_s + drawn(physics.after_camera_s, random);
  double exposure = 1, at_s = 0;
  for (;; at_s += period_s) {
    const bool is_first = times_.empty();
    const double jitter_s = is_first ? 0.0 : 1e-3 * physics.jitter_ms * std::clamp(random.normal(), -3.0, 3.0);
    const bool lost = !is_first && random.uniform() < physics.lost_frame_share;
    const bool steps = !is_first && random.uniform() < period_s * physics.exposure_steps_per_s;
    if (steps) exposure = std::clamp(exposure * drawn(physics.exposure_step, random), least_exposure, most_exposure);
    VideoTime t{microseconds{std::llround(1e6 * (at_s + jitter_s))}};
    if (!is_first) t = std::max(t, times_.back() + 1us);
    if (1e-6 * static_cast<double>(us_of(clocks.video.camera_from(t)) - clocks.camera_start_us) > end_s) break;
    if (lost) continue;
    times_.push_back(t);
    exposures_.push_back(exposure);
    noise_begins_.push_back(random.below(noise_pixels - frame_pixels + 1));
  }
  noise_ = draw_noise(physics.noise_grey, random);
}

cv::Mat SimulatedVideo::draw(std::size_t index) {
  const double exposure = exposures_.at(index);
  const auto seen = [&](double grey) { return std::min(exposure * grey, 255.0); };
  if (still_exposure_ != exposure) {
    still_ = cv::Mat(height, width, CV_8UC1, cv::Scalar(std::round(seen(70))));
    fill_box(still_, {0, table_px, width, height}, seen(105));
    still_exposure_ = exposure;
  }

  const double t_s = 1e-6 * static_cast<double>(us_of(clocks_->video.camera_from(times_[index])) - clocks_->camera_start_us);
  const double gap_px = px_per_mm * (closed_mm_ - plan_->stage_travel_at(t_s));
  // At rest the gripper must not touch the table. The arm's ringing is below a tenth of a pixel.
  const double middle = std::min(table_px - 0.55 * height_px_, table_px - 22) - px_per_mm * plan_->arm_travel_at(t_s);
  const double right_of_sensor = centre_px - half_width_px_ - gap_px, left_of_finger = centre_px + half_width_px_;
  cv::Mat frame = still_.clone();
  // The object stays in place where the light press does not hold it.
  const double lifted_px = plan_->lift && plan_->lift->firm_mm > 0 ? px_per_mm * plan_->arm_travel_at(t_s) : 0.0;
  fill_box(frame,
           {centre_px - half_width_px_, table_px - height_px_ - lifted_px, centre_px + half_width_px_, table_px - lifted_px},
           seen(grey_));
  fill_box(frame, {centre_px - 75, middle - 52, centre_px + 75, middle - 40}, seen(40));         // the gripper's bar
  fill_box(frame, {centre_px - 10, 0, centre_px + 10, middle - 52}, seen(55));                   // the arm
  fill_box(frame, {right_of_sensor - 26, middle - 40, right_of_sensor, middle + 18}, seen(25));  // the sensor on its stage
  fill_box(frame, {left_of_finger, middle - 40, left_of_finger + 8, middle + 18}, seen(210));    // the fixed finger

  std::uint8_t* pixels = frame.data;
  const std::int8_t* noise = noise_.data() + noise_begins_[index];
  for (std::size_t i = 0; i < frame_pixels; ++i) pixels[i] = static_cast<std::uint8_t>(std::clamp(pixels[i] + noise[i], 0, 255));
  return frame;
}

}  // namespace tactile::simulation
