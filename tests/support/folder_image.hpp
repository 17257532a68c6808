#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string>

#include "support/run_command.hpp"
#include "tactile/core/sha256.hpp"

namespace tactile::test {

/// The contents of a folder, by path: the bytes of a file, nothing for a folder.
using FolderImage = std::map<std::string, std::optional<std::string>>;

inline void write_image(const FolderImage& image, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  for (const auto& [path, content] : image) {  // a folder precedes its contents
    if (!content) {
      std::filesystem::create_directories(folder / path);
    } else {
      std::ofstream(folder / path, std::ios::binary).write(content->data(), static_cast<std::streamsize>(content->size()));
    }
  }
}

inline FolderImage image_of(const std::filesystem::path& folder) {
  FolderImage image;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    image[entry.path().lexically_relative(folder).string()] =
        entry.is_directory() ? std::nullopt : std::optional(text_in_file(entry.path()));
  }
  return image;
}

inline std::string hash_of(const FolderImage& image) {
  Sha256 hash;
  for (const auto& [path, content] : image) {
    hash.add(path + '\0' + (content ? "file " + std::to_string(content->size()) : std::string("folder")) + '\0');
    if (content) hash.add(*content);
  }
  return hash.hex();
}

}  // namespace tactile::test
