#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <numeric>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/core/sha256.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::test {

/// The contents of a dataset: SHA-256 of its events' columns and of each history, by name; the key "manifest" is its hash.
using DatasetContents = std::map<std::string, std::string>;

inline DatasetContents dataset_contents(const std::filesystem::path& file) {
  const windows::Dataset dataset(file);
  DatasetContents contents{{"manifest", dataset.manifest_hash()}};
  std::string t, x, y, on;
  for (std::uint32_t index = 0; index < dataset.runs().size(); ++index) {
    for (const events::Event& event : dataset.events(index)) {
      const std::int64_t t_us = us_of(event.t);
      t.append(reinterpret_cast<const char*>(&t_us), sizeof t_us);
      x.append(reinterpret_cast<const char*>(&event.x), sizeof event.x);
      y.append(reinterpret_cast<const char*>(&event.y), sizeof event.y);
      on += static_cast<char>(event.on);
    }
  }
  contents["events"] = sha256_of(t + x + y + on);
  std::vector<std::uint32_t> every(dataset.samples().size());
  std::iota(every.begin(), every.end(), 0U);
  for (const windows::StoredHeatmaps& stored : dataset.heatmaps()) {
    const std::vector<std::uint8_t> heatmaps = dataset.read_heatmaps(stored.name, every);
    contents[stored.name] = sha256_of(std::string_view(reinterpret_cast<const char*>(heatmaps.data()), heatmaps.size()));
  }
  return contents;
}

}  // namespace tactile::test
