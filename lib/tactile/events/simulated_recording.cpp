#include "tactile/events/simulated_recording.hpp"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/events/recording_file.hpp"

namespace tactile::events {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// MODEL_SERIAL, the serial `SIM` and digits.
bool is_simulators_camera(std::string_view source) {
  constexpr std::string_view begin = "_SIM";
  const std::size_t place = source.rfind(begin);
  if (place == std::string_view::npos) return false;
  const std::string_view number = source.substr(place + begin.size());
  return !number.empty() && std::all_of(number.begin(), number.end(), is_digit);
}

}  // namespace

bool is_simulated(std::span<const Stream> streams) {
  return std::any_of(streams.begin(), streams.end(), [](const Stream& stream) {
    const std::pair<std::string, std::string> says_so{simulated_attribute, "true"};
    return is_simulators_camera(stream.source) || std::find(stream.info.begin(), stream.info.end(), says_so) != stream.info.end();
  });
}

bool is_simulated(const RunFolder& run) {
  namespace fs = std::filesystem;
  if (fs::exists(run.info()) ? read_run_info(run).simulated : fs::exists(run.truth())) return true;
  try {
    return is_simulated(read_start(RecordingFile(run.events())).header.streams);
  } catch (const Error&) {
    return false;  // reading the events reports what is wrong
  }
}

}  // namespace tactile::events
