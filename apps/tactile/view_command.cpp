#include <fmt/core.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "command.hpp"
#include "commands.hpp"
#include "field_options.hpp"
#include "option_checks.hpp"
#include "rendering_arguments.hpp"
#include "tactile/core/error.hpp"
#include "view_outputs.hpp"
#include "viewed_recording.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;

struct ViewArguments {
  std::string what;
  std::string out;
  std::string stream;
  heatmaps::HeatmapOptions rendering;
  std::string mask;
  std::optional<int> tiles;
  std::optional<double> from_ms, to_ms;
  std::optional<double> fps, speed;
};

enum class Form : std::uint8_t { sheet, mp4, folder };

Form form_of(const std::string& out) {
  if (fs::is_directory(out) || (!out.empty() && out.back() == '/')) return Form::folder;
  const std::string extension = fs::path(out).extension().string();
  if (extension.empty()) return Form::folder;
  if (extension == ".png") return Form::sheet;
  if (extension == ".mp4") return Form::mp4;
  throw Error(
      fmt::format("{}: {} is not a form of view; expected .png for a contact sheet, .mp4 for a film, or a folder for single "
                  "pictures, {}/ if it is one",
                  out, extension, out));
}

void refuse(bool given, const char* option, const std::string& out, const char* what, const char* belongs_to) {
  if (given) throw Error(fmt::format("{}: {} is {}; expected it for {} only", option, out, what, belongs_to));
}

void view(const ViewArguments& args, const CommonArguments& common) {
  // Errors of options are reported before anything is read.
  std::optional<Form> form;
  if (!args.out.empty()) form = form_of(args.out);
  const Form wanted = form.value_or(Form::sheet);
  const std::string shown_out = args.out.empty() ? "the output" : args.out;
  if (wanted == Form::sheet) {
    refuse(args.fps.has_value(), "--fps", shown_out, "a contact sheet", "films (.mp4) and folders");
    refuse(args.speed.has_value(), "--speed", shown_out, "a contact sheet", "films (.mp4) and folders");
  } else {
    refuse(args.tiles.has_value(), "--tiles", shown_out, wanted == Form::mp4 ? "a film" : "a folder", "contact sheets (.png)");
  }
  ViewRequest request{.out = args.out,
                      .options = with_mask(args.rendering, args.mask),
                      .from_ms = args.from_ms,
                      .to_ms = args.to_ms,
                      .tiles = args.tiles};
  if (args.fps) request.fps = *args.fps;
  if (args.speed) request.speed = *args.speed;

  ViewedRecording recording(args.what, args.stream, common);
  check_mask(args.mask, request.options, recording.sensor());
  if (request.out.empty()) request.out = recording.file_stem() + ".png";
  switch (wanted) {
    case Form::sheet:
      return view_as_sheet(recording, request, common);
    case Form::mp4:
      return view_as_film(recording, request, FilmForm::mp4, common);
    case Form::folder:
      return view_as_film(recording, request, FilmForm::folder, common);
  }
}

}  // namespace

void add_view_command(CLI::App& app) {
  auto args = std::make_shared<ViewArguments>();
  Command command = add_command(app, "view", "Show events, heatmaps and labels of a recording as a picture or video",
                                [args](const CommonArguments& common) { view(*args, common); });
  command.add_option("what", args->what, "Recording (AEDAT4 or RAW), ROS bag, or run folder")
      .type_name("FILE|RUN")
      .required()
      .check(Check{[](std::string& text) {
                     return fs::exists(text) ? std::string()
                                             : fmt::format("there is no {}; expected a recording or a run's folder", text);
                   },
                   ""});
  command
      .add_option(
          "--out", args->out,
          "Contact sheet (.png), video (.mp4), or folder for single pictures; default: a contact sheet named after the recording")
      .type_name("FILE.png|FILE.mp4|DIR");
  command.add_option("--from-ms", args->from_ms, "Start of the part to show [ms after the first event]")
      .check(in_range(0.0, 1e12));
  command.add_option("--to-ms", args->to_ms, "End of the part to show [ms after the first event]").check(in_range(0.0, 1e12));
  command.add_option("--speed", args->speed, "Speed of a video: 0.1 is ten times slower than real time")
      .check(in_range(1e-4, 1e4))
      .default_text("0.1");
  command.add_option("--fps", args->fps, "Frame rate of a video [1/s]").check(in_range(1.0, 240.0)).default_text("25");
  command.add_option("--tiles", args->tiles, "Number of evenly spaced tiles in a contact sheet; default: tiles around the onsets")
      .check(in_range(1, 240));
  command.add_option("--stream", args->stream, "Event stream to use, if a recording has several").type_name("ID|SOURCE");
  add_field_options(command, args->rendering);
  add_mask_option(command, args->mask);
}

}  // namespace tactile::cli
