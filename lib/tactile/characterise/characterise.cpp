#include "tactile/characterise/characterise.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

#include "tactile/characterise/lit_pixels.hpp"
#include "tactile/characterise/second_reading.hpp"

namespace tactile::characterise {
namespace {

std::vector<std::string> names_of(const std::vector<std::filesystem::path>& files) {
  std::vector<std::string> names;
  names.reserve(files.size());
  for (const auto& file : files) names.push_back(file.string());
  return names;
}

}  // namespace

Sensor characterise(const std::vector<std::filesystem::path>& quiet, const std::vector<std::filesystem::path>& touched,
                    const CharacteriseOptions& options, const ProgressCallback& progress) {
  assert(!quiet.empty() && "there is a recording");
  const FirstReading first = read_first(quiet, options, progress);
  Sensor sensor;
  sensor.quiet = names_of(quiet);
  sensor.touched = names_of(touched);
  sensor.camera = first.camera;
  sensor.size = first.counts.size;
  sensor.seconds = first.counts.seconds;
  sensor.readout = first.readout;
  sensor.packets = first.packets;
  sensor.seconds_left_out = first.seconds_left_out;
  LightReading light = read_light(first, unusual_pixels(first.counts), options, progress);
  sensor.unusual = unusual_pixels(first.counts, light.lit);
  sensor.flicker = std::move(light.flicker);
  for (std::size_t i = 0; i < first.counts.pixels(); ++i)
    sensor.events += std::uint64_t{first.counts.on[i]} + first.counts.off[i];
  SecondReading second(first, sensor.unusual, !touched.empty());
  for (const ReadRecording& recording : first.recordings) {
    OpenRecording open(recording.file, options, first.counts.size);
    second.read_quiet(open, recording, progress);
  }
  for (const std::filesystem::path& file : touched) {
    OpenRecording open(file, options, first.counts.size);
    second.read_touched(open, progress);
  }
  second.put_into(sensor);
  return sensor;
}

}  // namespace tactile::characterise
