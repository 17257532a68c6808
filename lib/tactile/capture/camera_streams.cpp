#include "tactile/capture/camera_streams.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "tactile/core/error.hpp"

namespace tactile::capture {
namespace {

constexpr microseconds clock_was_set_back = 1s;

struct Keeper {
  std::optional<CameraTime>& latest;
  std::string_view name;

  bool keeps(CameraTime t) {
    if (latest && t < *latest) {
      if (between(t, *latest) > clock_was_set_back) {
        throw Error(fmt::format("{}: its time went back by {:.3f} s; expected a camera clock that is not reset while it is used",
                                name, 1e-6 * static_cast<double>(between(t, *latest).count())));
      }
      return false;
    }
    latest = t;
    return true;
  }

  template <class T>
  void keep(std::vector<T>& elements) {
    if (elements.empty()) return;
    const auto earlier = [](const T& a, const T& b) { return a.t < b.t; };
    if ((!latest || elements.front().t >= *latest) && std::is_sorted(elements.begin(), elements.end(), earlier)) {
      latest = elements.back().t;
      return;
    }
    std::erase_if(elements, [&](const T& element) { return !keeps(element.t); });
  }
};

}  // namespace

std::optional<std::string> info_of(const events::Stream& stream, std::string_view key) {
  for (const auto& [name, value] : stream.info) {
    if (name == key) return value;
  }
  return std::nullopt;
}

void set_info(events::Stream& stream, std::string_view key, std::string value) {
  for (auto& [name, old] : stream.info) {
    if (name == key) {
      old = std::move(value);
      return;
    }
  }
  stream.info.emplace_back(key, std::move(value));
}

nlohmann::json camera_json(std::span<const events::Stream> streams) {
  nlohmann::json json = nlohmann::json::object();
  for (const events::Stream& stream : streams) {
    if (!json.contains("source") && !stream.source.empty()) json["source"] = stream.source;
    const std::optional<std::string> mode = info_of(stream, readout_mode_attribute);
    if (mode && !json.contains("readout_mode")) json["readout_mode"] = *mode;
  }
  return json;
}

void AscendingTimes::keep(CameraPacket& packet, std::string_view name, SourceDrops& drops) {
  const LostElements came = count_of(packet);
  const auto lose = [&drops](const LostElements& lost) {
    drops += {.packets = lost.packets, .events = lost.events, .others = lost.others, .back_in_time = lost};
  };
  Keeper keeper{latest_, name};
  try {
    keeper.keep(packet.events);
    keeper.keep(packet.imu);
    keeper.keep(packet.triggers);
    if (packet.frame && !keeper.keeps(packet.frame->t)) packet.frame.reset();
  } catch (const Error&) {
    lose(came);
    packet.clear();
    throw;
  }
  const LostElements left = count_of(packet);
  LostElements lost = came - left;
  if (lost == LostElements{}) return;
  if (left.events + left.others == 0) lost.packets = 1;
  lose(lost);
}

}  // namespace tactile::capture
