#include "estimate_text.hpp"

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <string>
#include <vector>

#include "quantity_text.hpp"
#include "tactile/core/machine.hpp"
#include "text_table.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;

/// "25 min", "3.2 h"
std::string hours_text(double seconds) {
  return seconds < 3600 ? fmt::format("{:.0f} min", std::ceil(seconds / 60)) : fmt::format("{:.1f} h", seconds / 3600);
}

/// "27 MB", "1.3 GB"
std::string size_text(double bytes) {
  const double mb = bytes / 1e6;
  return mb < 1000 ? fmt::format("{:.0f} MB", std::ceil(mb)) : fmt::format("{:.1f} GB", mb / 1000);
}

nlohmann::json json_of(const experiments::Estimate& estimate) {
  nlohmann::json parts = nlohmann::json::array();
  for (const experiments::EstimatedPart& part : estimate.parts) {
    parts.push_back({{"what", part.what},
                     {"count", part.count},
                     {"exist", part.exist},
                     {"processor_s", part.seconds},
                     {"bytes", part.bytes},
                     {"jobs", part.one_thread}});
  }
  return {{"parts", parts},
          {"processor_s", estimate.processor_seconds()},
          {"cores", estimate.cores},
          {"seconds", estimate.seconds_on(estimate.cores, estimate.cores)},
          {"bytes", estimate.bytes()},
          {"images_per_s", estimate.images_per_s}};
}

std::string table_of(const experiments::Estimate& estimate, bool on_cluster) {
  std::vector<std::vector<std::string>> rows;
  for (const experiments::EstimatedPart& part : estimate.parts) {
    const bool is_done = part.exist == part.count;
    rows.push_back({part.what, std::to_string(part.count), std::to_string(part.exist), is_done ? "-" : hours_text(part.seconds),
                    is_done ? "-" : size_text(part.bytes)});
  }
  std::string text = text_table({"part", "steps", "exist", "processor time", "writes"}, rows);
  text += wrapped(fmt::format("In all: {} of processor time, {}, and {}.", hours_text(estimate.processor_seconds()),
                              duration_text(estimate), size_text(estimate.bytes()))) +
          "\n";
  if (on_cluster) {
    text += wrapped(fmt::format("With trainings and judgements on 16 cores of a cluster: {}; on 256 cores: {}.",
                                hours_text(estimate.seconds_on(estimate.cores, 16)),
                                hours_text(estimate.seconds_on(estimate.cores, 256)))) +
            "\n";
  }
  return text +
         wrapped(fmt::format("Estimated from this machine's training speed, {:.0f} heatmaps/s in one thread, and from {}.",
                             estimate.images_per_s, estimate.data)) +
         "\n";
}

}  // namespace

std::string duration_text(const experiments::Estimate& estimate) {
  return fmt::format("{} on {}", hours_text(estimate.seconds_on(estimate.cores, estimate.cores)),
                     counted(estimate.cores, "core"));
}

void print_estimate(const experiments::Estimate& estimate, const fs::path& out, bool on_cluster, const CommonArguments& common) {
  print_result(common, json_of(estimate), table_of(estimate, on_cluster));
  const auto free = free_bytes_at(out);
  if (free && static_cast<double>(*free) < estimate.bytes()) {
    spdlog::warn("{}: {} are free there; expected {}", out.string(), size_text(static_cast<double>(*free)),
                 size_text(estimate.bytes()));
  }
}

}  // namespace tactile::cli
