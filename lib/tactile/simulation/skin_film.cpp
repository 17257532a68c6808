#include "tactile/simulation/skin_film.hpp"

namespace tactile::simulation {
namespace {

constexpr std::size_t batch_events = 1 << 15;

}  // namespace

SkinFilm::SkinFilm(const SkinMotion& motion, const CameraPixels& pixels, const EventCameraOptions& options, CameraTime start,
                   std::uint64_t seed)
    : motion_(&motion), camera_(pixels, options, start, seed, motion.poses.front()), readout_(options.readout), start_(start) {
  filmed_.first_events.resize(motion.motions.size());
}

std::span<const events::Event> SkinFilm::next() {
  const EventCamera::ReadOut seen = camera_.read_out(motion_->poses[next_]);
  const microseconds since = readout_ * static_cast<std::int64_t>(next_);
  ++next_;
  filmed_.last_readout = start_ + since;
  filmed_.events += seen.events.size();
  filmed_.caused += seen.caused;
  if (seen.caused_by != 0) {
    for (std::size_t i = 0; i < motion_->motions.size(); ++i) {
      const MarkerMotion& motion = motion_->motions[i];
      if (motion.start >= since) break;
      const bool takes_part = (seen.caused_by & motion.markers) != 0 && since <= motion.end;
      if (takes_part && !filmed_.first_events[i]) filmed_.first_events[i] = filmed_.last_readout;
    }
  }
  return seen.events;
}

void film_whole(SkinFilm& film, const std::function<void(std::span<const events::Event>)>& use,
                const std::function<void(double)>& tell_share) {
  std::vector<events::Event> batch;
  for (std::size_t k = 0; !film.ended(); ++k) {
    const double share = film.share_done();
    const std::span<const events::Event> events = film.next();
    batch.insert(batch.end(), events.begin(), events.end());
    if (batch.size() >= batch_events) {
      use(batch);
      batch.clear();
    }
    if (tell_share && k % 500 == 0) tell_share(share);
  }
  if (!batch.empty()) use(batch);
}

}  // namespace tactile::simulation
