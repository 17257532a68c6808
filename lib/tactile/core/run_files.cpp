#include "tactile/core/run_files.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <system_error>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/sha256.hpp"

namespace tactile {
namespace fs = std::filesystem;
namespace {

bool is_compared(const std::string& name) { return name != "labels.json" && name != "run.json"; }

/// Whether a name is a file in the run's folder.
bool is_plain_name(const std::string& name) {
  return !name.empty() && name != "." && name != ".." && name.find('/') == std::string::npos &&
         name.find('\0') == std::string::npos;
}

/// What is wrong with the file of `entry`; empty if nothing is.
std::string fault_in(const fs::path& file, const nlohmann::json& entry, FileComparison comparison,
                     const std::function<void(std::uint64_t)>& report_bytes) {
  const std::string where = "run.json: '" + file.filename().string() + "'";
  try {
    const auto bytes = member<std::uint64_t>(entry, "bytes", where);
    const auto sha256 = member<std::string>(entry, "sha256", where);
    std::error_code failed;
    const std::uint64_t there = fs::file_size(file, failed);
    if (failed) return fmt::format("{}: its size cannot be read ({}); expected a file", file.string(), failed.message());
    if (there != bytes) return fmt::format("{}: has {} bytes; expected {}, as run.json lists", file.string(), there, bytes);
    if (comparison == FileComparison::contents && sha256_of_file(file, report_bytes) != sha256)
      return file.string() + ": has changed; expected the SHA-256 that run.json lists";
    return {};
  } catch (const Error& e) {
    return e.what();
  }
}

}  // namespace

nlohmann::json files_json(std::span<const fs::path> files) {
  nlohmann::json json = nlohmann::json::object();
  for (const fs::path& file : files) {
    const std::string sha256 = sha256_of_file(file);
    std::error_code failed;
    const std::uint64_t bytes = fs::file_size(file, failed);
    if (failed) throw Error(file.string() + ": its size cannot be read (" + failed.message() + "); expected a readable file");
    json[file.filename().string()] = {{"sha256", sha256}, {"bytes", bytes}};
  }
  return json;
}

RunFiles check_files(const RunFolder& run, const RunInfo& info, FileComparison comparison, const ProgressCallback& progress) {
  RunFiles files;
  const auto found = info.extra.find("files");
  const nlohmann::json listed = found == info.extra.end() ? nlohmann::json::object() : *found;
  files.is_listed = found != info.extra.end();
  if (!listed.is_object()) {
    files.reasons.push_back(run.info().string() + ": 'files' is no object; expected {name: {sha256, bytes}}");
    return files;
  }
  std::error_code ignored;
  std::uint64_t total = 0, done = 0;
  if (comparison == FileComparison::contents) {
    for (const auto& [name, entry] : listed.items()) {
      const std::uint64_t size = is_plain_name(name) ? fs::file_size(run.folder / name, ignored) : 0;
      if (!ignored) total += size;
    }
  }
  for (const auto& [name, entry] : listed.items()) {
    if (!is_compared(name)) continue;
    if (!is_plain_name(name)) {
      files.changed.push_back(name);
      files.reasons.push_back(run.info().string() + ": 'files' lists '" + name + "'; expected names of files in its folder");
      continue;
    }
    const fs::path file = run.folder / name;
    if (!fs::is_regular_file(file, ignored)) {
      files.missing.push_back(name);
      files.reasons.push_back(file.string() + ": is missing; run.json lists it");
      continue;
    }
    const std::string fault = fault_in(file, entry, comparison, [&](std::uint64_t bytes) {
      report_progress(progress, done += bytes, total, "hashing " + file.string());
    });
    (fault.empty() ? files.as_listed : files.changed).push_back(name);
    if (!fault.empty()) files.reasons.push_back(fault);
  }
  for (const fs::path& file : std::array{run.events(), run.robot(), run.video(), run.video_times(), run.truth()}) {
    const std::string name = file.filename().string();
    if (!listed.contains(name) && fs::exists(file, ignored)) files.not_listed.push_back(name);
  }
  return files;
}

}  // namespace tactile
