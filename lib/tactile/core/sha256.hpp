#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace tactile {

/// A SHA-256 digest in the making.
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(Sha256&&) noexcept;
  Sha256& operator=(Sha256&&) noexcept;

  void add(std::span<const std::byte> bytes);
  void add(std::string_view text);
  std::string hex();  ///< 64 lower-case digits; ends the digest, nothing may be added after it

 private:
  struct State;
  std::unique_ptr<State> state_;
};

std::string sha256_of(std::string_view text);

/// Read in chunks. @throws Error if the file cannot be read
std::string sha256_of_file(const std::filesystem::path& file);

}  // namespace tactile
