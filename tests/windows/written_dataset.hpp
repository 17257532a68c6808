#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::test {

/// A folder of runs and the dataset of them.
class WriteDataset : public ::testing::Test {
 protected:
  std::filesystem::path data() const { return folder.path() / "data"; }
  std::filesystem::path file() const { return data() / "dataset.h5"; }
  TemporaryFolder folder;
};

inline std::string message_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& e) {
    return e.what();
  }
  return "nothing thrown";
}

inline void append_to(windows::HeatmapsWriter& writer, std::vector<std::uint8_t> heatmaps) {
  const windows::HeatmapsWriter::Packed packed = writer.packed(std::move(heatmaps));
  writer.add_to_digest(packed.heatmaps);
  writer.append(packed.chunks);
}

inline bool mentions(const std::vector<std::string>& texts, const std::string& part) {
  return std::any_of(texts.begin(), texts.end(), [&](const std::string& text) { return text.find(part) != std::string::npos; });
}

}  // namespace tactile::test
