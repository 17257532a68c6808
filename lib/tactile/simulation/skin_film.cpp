#include "tactile/simulation/skin_film.hpp"

#include <algorithm>

namespace tactile::simulation {
namespace {

constexpr std::size_t batch_events = 1 << 15;

}  // namespace

SkinFilm::SkinFilm(const SkinMotion& motion, const CameraPixels& pixels, const EventCameraOptions& options, CameraTime start,
                   std::uint64_t seed)
    : motion_(&motion),
      camera_(pixels, options, start, seed, motion.poses.front()),
      start_(start),
      last_us_(static_cast<double>(motion.step.count()) * static_cast<double>(motion.poses.size() - 1)) {
  filmed_.first_events.resize(motion.motions.size());
}

SkinPose SkinFilm::pose_at(double us) const {
  const double place = us / static_cast<double>(motion_->step.count());
  const auto before = static_cast<std::size_t>(place);
  const double share = place - static_cast<double>(before);
  SkinPose pose = motion_->poses[before];
  if (share == 0 || before + 1 >= motion_->poses.size()) return pose;
  const SkinPose& next = motion_->poses[before + 1];
  for (std::size_t m = 0; m < marker_count; ++m) {
    pose[m].x += share * (next[m].x - pose[m].x);
    pose[m].y += share * (next[m].y - pose[m].y);
    pose[m].scale += share * (next[m].scale - pose[m].scale);
  }
  return pose;
}

std::span<const events::Event> SkinFilm::next() {
  const double us = camera_.next_us();
  const EventCamera::ReadOut seen = camera_.read_out(pose_at(us));
  const microseconds since{static_cast<std::int64_t>(us)};
  filmed_.last_readout = start_ + since;
  filmed_.events += seen.events.size();
  filmed_.caused += seen.caused;
  if (seen.caused_by != 0) {
    for (std::size_t i = 0; i < motion_->motions.size(); ++i) {
      const MarkerMotion& motion = motion_->motions[i];
      if (motion.start >= since) break;
      const std::uint32_t causes = seen.caused_by & motion.markers;
      if (causes == 0 || since > motion.end || filmed_.first_events[i]) continue;
      for (std::size_t m = 0; m < marker_count; ++m) {
        if ((causes >> m & 1U) == 0) continue;
        filmed_.first_events[i] = std::min(filmed_.first_events[i].value_or(CameraTime::max()), seen.first_by[m]);
      }
    }
  }
  return seen.events;
}

void film_whole(SkinFilm& film, const std::function<void(std::span<const events::Event>)>& use,
                const std::function<void(double)>& report_share) {
  std::vector<events::Event> batch;
  for (std::size_t k = 0; !film.ended(); ++k) {
    const double share = film.share_done();
    const std::span<const events::Event> events = film.next();
    batch.insert(batch.end(), events.begin(), events.end());
    if (batch.size() >= batch_events) {
      use(batch);
      batch.clear();
    }
    if (report_share && k % 500 == 0) report_share(share);
  }
  if (!batch.empty()) use(batch);
}

}  // namespace tactile::simulation
