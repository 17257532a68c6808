#include "tactile/capture/recorded_stream.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "tactile/core/error.hpp"

namespace tactile::capture {
namespace {

int rank_of(events::StreamType type) {
  constexpr std::array ranks{events::StreamType::events, events::StreamType::imu, events::StreamType::triggers,
                             events::StreamType::frames};
  return static_cast<int>(std::find(ranks.begin(), ranks.end(), type) - ranks.begin());
}

}  // namespace

std::vector<RecordedStream> recorded_streams(std::span<const std::unique_ptr<CameraSource>> sources) {
  std::vector<RecordedStream> all;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    for (const events::Stream& stream : sources[i]->streams()) {
      if (stream.type == events::StreamType::other) continue;
      const auto twice = std::find_if(all.begin(), all.end(), [&](const RecordedStream& other) {
        return other.source_index != i && other.stream.type == stream.type && other.stream.source == stream.source;
      });
      if (twice != all.end()) {
        throw Error(fmt::format("{}: has the {} of the camera '{}', as {} does; expected each stream once", sources[i]->name(),
                                name_of(stream.type), stream.source, sources[twice->source_index]->name()));
      }
      all.push_back({.stream = stream, .source_index = i, .source_stream = stream.id});
    }
  }
  std::stable_sort(all.begin(), all.end(), [](const RecordedStream& a, const RecordedStream& b) {
    return rank_of(a.stream.type) < rank_of(b.stream.type);
  });
  if (all.empty() || all.front().stream.type != events::StreamType::events || !all.front().stream.size) {
    throw Error(fmt::format("{}: has no events of a sensor with a declared size; expected a source with events",
                            sources.empty() ? "no source" : sources.front()->name()));
  }
  const std::string camera = all.front().stream.source.empty() ? "camera" : all.front().stream.source;
  for (std::size_t i = 0; i < all.size(); ++i) {
    events::Stream& stream = all[i].stream;
    stream = completed(std::move(stream), camera);
    stream.id = static_cast<std::int32_t>(i);
    stream.type_identifier.clear();
    if (stream.type == events::StreamType::frames && !stream.size) stream.size = all.front().stream.size;
  }
  return all;
}

}  // namespace tactile::capture
