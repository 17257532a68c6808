#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "command.hpp"
#include "viewed_recording.hpp"

namespace tactile::cli {

/// What `tactile view` is asked for, whatever it writes.
struct ViewRequest {
  std::filesystem::path out;
  heatmaps::HeatmapOptions options;
  std::optional<double> from_ms, to_ms;  ///< from the first event
  std::optional<int> tiles;              ///< of a contact sheet
  double fps = 25;                       ///< of a film, > 0
  double speed = 0.1;                    ///< of a film: how much recording passes in one second of it [s], > 0
};

/// Draws moments around the onsets, or evenly spaced ones, as one PNG, and prints what became of it.
void view_as_sheet(ViewedRecording& recording, const ViewRequest& request, const CommonArguments& common);

enum class FilmForm : std::uint8_t { mp4, folder };

/// Draws moments one after the other as an MP4 or as a folder of PNGs, and prints what became of it.
void view_as_film(ViewedRecording& recording, const ViewRequest& request, FilmForm form, const CommonArguments& common);

}  // namespace tactile::cli
