#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "command.hpp"
#include "commands.hpp"
#include "quantity_text.hpp"
#include "readout_text.hpp"
#include "tactile/characterise/characterise.hpp"
#include "tactile/characterise/physics_file.hpp"
#include "tactile/characterise/sensor_json.hpp"
#include "tactile/core/csv_table.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json_text.hpp"
#include "tactile/core/make_folders.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/pictures/sensor_picture.hpp"
#include "text_table.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;
using characterise::Sensor;

struct CharacteriseArguments {
  std::vector<std::string> quiet, touched;
  std::string out = "sensor", stream;
  bool force = false;
};

constexpr std::array written{"sensor.json", "sensor.png", "mask.csv", "physics.json"};

std::vector<fs::path> recordings_of(const std::vector<std::string>& places) {
  std::vector<fs::path> files;
  files.reserve(places.size());
  for (const std::string& place : places) files.push_back(fs::is_directory(place) ? recording_in(place) : fs::path(place));
  return files;
}

void check_folder(const CharacteriseArguments& args) {
  if (args.force) return;
  for (const char* name : written) {
    if (fs::exists(fs::path(args.out) / name))
      throw Error((fs::path(args.out) / name).string() + ": exists already; expected another --out, or --force to replace it");
  }
}

std::string mask_text(const Sensor& sensor) {
  CsvTable table("x,y,kind,rate_hz");
  for (const characterise::UnusualPixel& pixel : sensor.unusual.pixels) {
    if (!pixel.is_hot()) continue;
    table.add_row(pixel.x, pixel.y, name_of(pixel.kind), fmt::format("{:.6g}", pixel.rate_hz.value));
  }
  return table.text();
}

std::string percent_text(const Measured& share) { return measured_text({100 * share.value, 100 * share.uncertainty}) + " %"; }

std::string dead_text(const characterise::DeadPixels& dead) {
  if (!dead.is_known())
    return fmt::format("not known: {} never fired; in this short time {:.0f} are expected", counted(dead.silent, "pixel"),
                       dead.expected);
  return fmt::format("{}; {} never fired", measured_text(dead.count), counted(dead.silent, "pixel"));
}

std::string flicker_text(const characterise::Flicker& flicker) {
  if (flicker.to_hz <= flicker.from_hz) return "not searched: the recordings are too short, or the read-outs too slow";
  if (flicker.lines.empty()) return fmt::format("none from {:.0f} to {:.0f} Hz", flicker.from_hz, flicker.to_hz);
  std::string text;
  for (const auto& [line, multiples] : characterise::series_of(flicker))
    text +=
        fmt::format("{}{} Hz{} ({} of the rate{})", text.empty() ? "" : ", ", measured_text(line.hz),
                    multiples > 0 ? fmt::format(" and {} of it", counted(multiples, "multiple")) : "", percent_text(line.depth),
                    line.is_local ? fmt::format(" of {} in step with it", counted(line.lit_pixels, "pixel")) : "");
  return text;
}

std::vector<std::pair<std::string, std::string>> rows_of(const Sensor& sensor) {
  const characterise::Background& background = sensor.background;
  const characterise::UnusualPixels& unusual = sensor.unusual;
  std::vector<std::pair<std::string, std::string>> rows{
      {"events", fmt::format("{} in {:.3f} s: {} events/s, {} without hot pixels", sensor.events, sensor.seconds,
                             measured_text(sensor.rate_hz), measured_text(sensor.rate_without_hot_hz))}};
  if (sensor.seconds_left_out > 0)
    rows.emplace_back("left out", fmt::format("{:.3f} s in which something moves", sensor.seconds_left_out));
  rows.emplace_back("read-out", readout_text(sensor.readout));
  rows.emplace_back("stamps", precision_text(sensor.readout));
  if (sensor.readout.kind == events::Readout::Kind::steady)
    rows.emplace_back("jitter", fmt::format("{} us; slow wander {} us", measured_text(sensor.readout.jitter_us),
                                            measured_text(sensor.readout.wander_us)));
  if (sensor.packets)
    rows.emplace_back("packets", fmt::format("an event waits {} us for the end of its packet, {:.0f} us at most",
                                             measured_text(sensor.packets->wait_us), sensor.packets->longest_us));
  rows.insert(rows.end(),
              {{"background", fmt::format("{} ON, {} OFF per pixel and s; spread {} decades; regularity {}",
                                          measured_text(background.on_hz), measured_text(background.off_hz),
                                          measured_text(background.spread_decades), measured_text(background.regularity))},
               {"hot pixels", fmt::format("{} with {} of the events; {} stuck",
                                          measured_text({unusual.hot.value + unusual.stuck.value, unusual.hot.uncertainty}),
                                          percent_text(unusual.hot_share), unusual.stuck.value)},
               {"warm pixels", measured_text(unusual.warm)},
               {"dead pixels", dead_text(sensor.dead)},
               {"flicker", flicker_text(sensor.flicker)},
               {"neighbours", fmt::format("correlation {} across, {} down, in 2 ms", measured_text(sensor.neighbours.horizontal),
                                          measured_text(sensor.neighbours.vertical))},
               {"refractory", sensor.refractory_us
                                  ? fmt::format("{} us; the shortest interval is {} us", measured_text(*sensor.refractory_us),
                                                measured_text(*sensor.shortest_interval_us))
                                  : std::string("too few intervals")},
               {"most events",
                fmt::format("of a pixel {} in 2 ms, {} in 40 ms; of an ordinary one {} and {}",
                            measured_text(sensor.largest.tick), measured_text(sensor.largest.history),
                            measured_text(sensor.largest_ordinary.tick), measured_text(sensor.largest_ordinary.history))}});
  if (unusual.lit > 0)
    rows.emplace_back("lit pixels", fmt::format("{} fire in step with the flicker, and are neither hot nor warm", unusual.lit));
  if (sensor.passages)
    rows.emplace_back("passages", fmt::format("{} ON and {} OFF events as a marker's edge passes a pixel",
                                              measured_text(sensor.passages->on), measured_text(sensor.passages->off)));
  return rows;
}

std::string text_of(const Sensor& sensor, const fs::path& out) {
  std::string text = fmt::format("{}, {} x {} pixels\n", sensor.camera.empty() ? "A sensor without name" : sensor.camera,
                                 sensor.size.width, sensor.size.height);
  for (const auto& [label, words] : rows_of(sensor)) text += fmt::format("  {:<13}{}\n", label, wrapped(words, 15));
  text += "Written to " + out.string() + ":";
  for (const char* name : written) text += fmt::format(" {}", name);
  return text + "\n";
}

void characterise_sensor(const CharacteriseArguments& args, const CommonArguments& common) {
  check_folder(args);
  const Sensor sensor = characterise::characterise(recordings_of(args.quiet), recordings_of(args.touched),
                                                   {.stream = args.stream, .threads = common.threads}, progress_line(common));
  if (sensor.background.is_disturbed()) {
    spdlog::warn("the pixels fire in bursts (regularity {:.2f}): something moves or flickers, and the noise includes it",
                 sensor.background.regularity.value);
  }
  constexpr double enough_events = 0.4;  // of a pixel: with fewer, the real still scene seems more regular than it is
  const double pixels = static_cast<double>(sensor.size.width) * sensor.size.height;
  if (const double per_pixel = sensor.rate_without_hot_hz.value * sensor.seconds / pixels; per_pixel < enough_events) {
    spdlog::warn(
        "{:.2f} events per pixel are too few for the spread and the regularity of the background; expected {} or more: "
        "record for {:.0f} s",
        per_pixel, enough_events, std::ceil(sensor.seconds * enough_events / std::max(per_pixel, 1e-9)));
  }
  const fs::path out = args.out;
  make_folders(out);
  nlohmann::json json = characterise::json_of(sensor);
  // A file that appeared since the check is not replaced either.
  const IfThere if_there = args.force ? IfThere::replace : IfThere::refuse;
  WholeFile picture(out / "sensor.png", if_there);
  pictures::draw_sensor(sensor, picture.path());
  picture.commit();
  write_whole(out / "mask.csv", mask_text(sensor), if_there);
  write_whole(out / "physics.json", json_text(characterise::physics_of(sensor), 2) + "\n", if_there);
  write_whole(out / "sensor.json", json_text(json, 2) + "\n", if_there);
  json["out"] = out.string();
  print_result(common, json, text_of(sensor, out));
}

}  // namespace

void add_characterise_command(CLI::App& app) {
  auto args = std::make_shared<CharacteriseArguments>();
  Command command = add_command(app, "characterise", "Measure what a sensor does: read-out, noise, hot pixels, flicker",
                                [args](const CommonArguments& common) { characterise_sensor(*args, common); });
  command.add_option("recordings", args->quiet, "Recordings or runs with times in which nothing touches the sensor")
      .type_name("FILE|RUN")
      .required();
  command.add_option("--touched", args->touched, "Recordings or runs in which markers move, for the events per passage")
      .type_name("FILE|RUN");
  command.add_option("--out", args->out, "Folder for sensor.json, sensor.png, mask.csv and physics.json")
      .type_name("DIR")
      .show_default();
  command.add_option("--stream", args->stream, "The event stream, by id or source").type_name("ID|SOURCE");
  command.add_flag("--force", args->force, "Replace existing files");
}

}  // namespace tactile::cli
