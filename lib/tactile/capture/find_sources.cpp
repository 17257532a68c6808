#include "tactile/capture/find_sources.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <optional>

#include "tactile/capture/camera_streams.hpp"
#include "tactile/capture/dv_bridge.hpp"
#include "tactile/capture/libcaer_camera.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/events/simulated_recording.hpp"
#include "tactile/transport/dv/dv_stream_client.hpp"

namespace tactile::capture {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t inivation = 0x152a;
constexpr std::uint32_t dvxplorer = 0x8419;
constexpr std::uint32_t mini_device_type = 4;

/// The printable characters of the first line of a file in sysfs; empty if there is none.
std::string line_in(const fs::path& file) {
  std::string line;
  std::ifstream stream(file);
  std::getline(stream, line);
  std::erase_if(line, [](unsigned char c) { return c < ' ' || c == 0x7F; });
  while (!line.empty() && line.back() == ' ') line.pop_back();
  return line;
}

std::optional<std::uint32_t> hex_in(const fs::path& file) {
  const std::string line = line_in(file);
  std::uint32_t value = 0;
  const auto [end, failed] = std::from_chars(line.data(), line.data() + line.size(), value, 16);
  if (line.empty() || failed != std::errc{} || end != line.data() + line.size()) return std::nullopt;
  return value;
}

std::vector<fs::path> entries_of(const fs::path& folder) {
  std::vector<fs::path> entries;
  std::error_code failed;
  for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end; entry.increment(failed))
    entries.push_back(entry->path());
  std::sort(entries.begin(), entries.end());
  return entries;
}

/// The vendor's cameras at the USB that are not in `opened`.
void add_usb_cameras(const fs::path& sysfs, const std::vector<FoundSource>& opened, std::vector<FoundSource>& found) {
  for (const fs::path& device : entries_of(sysfs / "bus" / "usb" / "devices")) {
    if (hex_in(device / "idVendor") != inivation) continue;
    const std::string serial = line_in(device / "serial");
    const auto has_serial = [&](const FoundSource& source) { return !serial.empty() && source.serial == serial; };
    if (std::any_of(opened.begin(), opened.end(), has_serial)) continue;

    const std::uint32_t version = hex_in(device / "bcdDevice").value_or(0);
    const std::uint32_t firmware = version & 0xFF;
    const bool is_dvxplorer = hex_in(device / "idProduct") == dvxplorer;
    const bool is_mini = is_dvxplorer && version >> 8 == mini_device_type;
    std::string model = is_mini ? "DVXplorer Mini" : is_dvxplorer ? "DVXplorer" : line_in(device / "product");
    if (model.empty()) model = "iniVation camera";
    const std::string what = fmt::format("{}{}, firmware {}", model, serial.empty() ? "" : " " + serial, firmware);

    std::string how;
    if (is_dvxplorer && is_built_with_libcaer() && firmware < first_foreign_firmware) {
      how = "cannot be opened; expected permission (the vendor's udev rules), and no other program that uses it";
    } else {
      how = fmt::format(
          "{}; run {} and record --from tcp://127.0.0.1:7777",
          !is_dvxplorer || firmware >= first_foreign_firmware ? "libcaer does not support it" : "this build has no libcaer",
          dv_bridge());
    }
    found.push_back({"", fmt::format("{}: {}", what, how), serial});
  }
}

void add_stream(const SourcePlaces& places, std::vector<FoundSource>& found) {
  try {
    const transport::DvStreamClient client(transport::network_address(places.stream), places.stream_patience);
    const events::Stream& stream = client.stream();
    std::string what = fmt::format("DV stream of {} from {}", name_of(stream.type), stream.source);
    if (stream.size) what += fmt::format(", {}x{}", stream.size->width, stream.size->height);
    if (const auto mode = info_of(stream, readout_mode_attribute)) what += ", read-out " + *mode;
    if (events::is_simulated({&stream, 1})) what += ", simulated";
    found.push_back({places.stream, what, ""});
  } catch (const Error&) {
    // No server, or no DV stream: not a source.
  }
}

}  // namespace

std::vector<FoundSource> find_camera_sources(const SourcePlaces& places) {
  std::vector<FoundSource> found = find_libcaer_cameras();
  add_usb_cameras(places.sysfs, std::vector<FoundSource>(found), found);
  add_stream(places, found);
  return found;
}

std::vector<FoundSource> find_video_devices(const SourcePlaces& places) {
  std::vector<std::pair<std::int64_t, FoundSource>> numbered;
  for (const fs::path& entry : entries_of(places.sysfs / "class" / "video4linux")) {
    const std::string name = entry.filename().string();
    const auto number = name.starts_with("video") ? whole_number_in(std::string_view(name).substr(5)) : std::nullopt;
    const fs::path node = places.devices / name;
    // A camera's further nodes, of index 1 and up, have metadata instead of pictures.
    if (!number || !fs::exists(node) || hex_in(entry / "index").value_or(0) > 0) continue;
    std::string what = line_in(entry / "name");
    if (what.empty()) what = "video device";
    const std::string serial = line_in(entry / "device" / ".." / "serial");
    if (!serial.empty()) what += ", serial " + serial;
    numbered.push_back({*number, {node.string(), what, serial}});
  }
  std::sort(numbered.begin(), numbered.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<FoundSource> found;
  found.reserve(numbered.size());
  for (auto& [number, source] : numbered) found.push_back(std::move(source));
  return found;
}

}  // namespace tactile::capture
