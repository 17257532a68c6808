#include "tactile/live/live_pictures.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "tactile/live/scene_warnings.hpp"
#include "tactile/review/count_bytes.hpp"

namespace tactile::live {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds between_pictures{25}, between_scenes{5'000}, silence{500};
constexpr std::size_t most_earlier_scenes = 60;

}  // namespace

LivePictures::LivePictures(EventWatch& watch, events::SensorSize sensor, heatmaps::HeatmapOptions rendering)
    : watch_(watch), sensor_(sensor), rendering_(std::move(rendering)) {
  heatmaps::HeatmapRenderer(sensor_, rendering_);
}

void LivePictures::look(Time now) {
  if (watch_.picture().is_full()) take_picture();
  if (watch_.scene().is_full()) take_scene();
  const std::uint64_t events = watch_.events();
  if (events != std::exchange(events_, events)) {
    last_event_ = now;
    is_empty_ = false;
  } else if (now - last_event_ >= silence && !std::exchange(is_empty_, true)) {
    draw({}, {}, rendering_.history);
  }
  if (now - picture_wanted_ >= between_pictures) {
    picture_wanted_ = now;
    watch_.picture().want();
  }
  if (now - scene_wanted_ >= between_scenes) {
    scene_wanted_ = now;
    watch_.scene().want();
  }
}

void LivePictures::take_picture() {
  const SampledWindow& window = watch_.picture();
  draw(window.events(), window.end(), window.length());
  watch_.picture().put_back();
}

void LivePictures::draw(std::span<const events::Event> events, CameraTime end, std::chrono::microseconds length) {
  review::CountBytes counts(sensor_);
  counts.add(events);
  heatmaps::HeatmapRenderer renderer(sensor_, rendering_);
  renderer.add(inside_the_sensor(events));
  renderer.move_to(end);
  const events::SensorSize size = renderer.size();
  std::vector<std::uint8_t> heatmap(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height));
  renderer.render(std::span(heatmap));
  ++newest_.number;
  newest_.length = length;
  newest_.events = std::make_shared<const std::string>(counts.bytes());
  newest_.heatmap = std::make_shared<const std::string>(review::heatmap_bytes(size, renderer.events(), heatmap));
}

void LivePictures::take_scene() {
  const SampledWindow& window = watch_.scene();
  const double seconds = std::chrono::duration<double>(window.length()).count();
  if (seconds > 0) {
    const std::vector<events::Event> events = inside_the_sensor(window.events());
    newest_.scene = characterise::scene_of(events, seconds, sensor_, rendering_.mask);
    const std::vector<characterise::Scene> earlier(earlier_.begin(), earlier_.end());
    newest_.warnings = scene_warnings(*newest_.scene, earlier, sensor_);
    earlier_.push_back(*newest_.scene);
    if (earlier_.size() > most_earlier_scenes) earlier_.pop_front();
  }
  watch_.scene().put_back();
}

std::vector<events::Event> LivePictures::inside_the_sensor(std::span<const events::Event> events) const {
  std::vector<events::Event> inside;
  inside.reserve(events.size());
  std::copy_if(events.begin(), events.end(), std::back_inserter(inside), [&](const events::Event& event) {
    return event.x >= 0 && event.y >= 0 && event.x < sensor_.width && event.y < sensor_.height;
  });
  return inside;
}

}  // namespace tactile::live
