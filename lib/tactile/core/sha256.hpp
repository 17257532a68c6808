#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
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

/// Read in chunks; `report_bytes` gets the size of each, and may throw to end it. @throws Error if the file cannot be read
std::string sha256_of_file(const std::filesystem::path& file, const std::function<void(std::uint64_t)>& report_bytes = {});

}  // namespace tactile
