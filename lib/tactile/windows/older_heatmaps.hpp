#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tactile/windows/dataset.hpp"

namespace tactile::windows {

/// The heatmaps of an older dataset in the file that a new history replaces. Those of a run stay if they are rendered from the
/// same (`source_sha256_of`).
class OlderHeatmaps {
 public:
  /// The file next to `dataset` with the same name and settings. Nothing if there is none, or it has another rendering, or comes
  /// from a version that does not list its runs. @throws Error  if it is damaged
  static std::optional<OlderHeatmaps> find(const std::filesystem::path& dataset, const StoredHeatmaps& wanted);
  ~OlderHeatmaps();
  OlderHeatmaps(OlderHeatmaps&&) noexcept;
  OlderHeatmaps& operator=(OlderHeatmaps&&) noexcept;

  /// The heatmaps of a run as they are stored, a chunk each. Empty if they are not in the file. Several threads may call it.
  /// @throws Error  if they are damaged
  std::vector<std::vector<std::uint8_t>> chunks_of(const std::string& source_sha256) const;

 private:
  struct State;
  explicit OlderHeatmaps(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// Whether a file of heatmaps lists a run that is rendered from one of `sources`. False too if it cannot be read.
bool lists_a_source(const std::filesystem::path& heatmaps, const std::set<std::string>& sources);

}  // namespace tactile::windows
