#include "live_view.hpp"

#include <fmt/core.h>

#include "quantity_text.hpp"
#include "tactile/core/machine.hpp"

namespace tactile::cli {

nlohmann::json disk_json(const std::filesystem::path& folder, std::optional<double> bytes_per_s,
                         std::vector<std::string>& warnings) {
  constexpr double least_minutes = 10;
  constexpr std::uint64_t least_bytes = 1'000'000'000;
  const std::optional<std::uint64_t> free = free_bytes_at(folder);
  if (!free) return nullptr;
  nlohmann::json json = {{"free_bytes", *free}, {"minutes", nullptr}};
  double minutes = least_minutes;
  if (bytes_per_s) {
    minutes = static_cast<double>(*free) / *bytes_per_s / 60;
    json["minutes"] = minutes;
  }
  if (minutes < least_minutes)
    warnings.push_back(fmt::format("the disk is full in {:.1f} min at this rate", minutes));
  else if (*free < least_bytes)
    warnings.push_back("the disk has only " + bytes_text(*free) + " left");
  return json;
}

}  // namespace tactile::cli
