#include <fcntl.h>
#include <fmt/core.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <set>
#include <thread>

#include "command.hpp"
#include "commands.hpp"
#include "library_versions.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/machine.hpp"
#include "tactile/core/robust_statistics.hpp"
#include "tactile/core/text.hpp"
#include "tactile/core/version.hpp"
#include "tactile/model/training/torch_version.hpp"
#include "tactile/video/picture_codec.hpp"
#include "text_table.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// The files of this process's shared libraries whose names contain `part`.
std::set<std::string> loaded_libraries(std::string_view part) {
  std::set<std::string> found;
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    const auto slash = line.find('/');
    if (slash == std::string::npos) continue;
    const fs::path file = line.substr(slash);
    if (file.filename().string().find(part) != std::string::npos) found.insert(file.string());
  }
  return found;
}

struct Blas {
  std::string name;
  std::string file;
  bool slow = false;
};

/// Debian selects one of several packages as BLAS: the folder that libblas.so.3 links to shows which.
Blas blas_in_use() {
  const std::set<std::string> files = loaded_libraries("libblas.so");
  for (const std::string& file : files) {
    for (const auto& [part, name] :
         {std::pair{"openblas", "OpenBLAS"}, std::pair{"blis", "BLIS"}, std::pair{"mkl", "MKL"}, std::pair{"atlas", "ATLAS"}}) {
      if (file.find(part) != std::string::npos) return {name, file, false};
    }
    return {"the reference BLAS", file, true};
  }
  for (const std::string& file : loaded_libraries("libopenblas")) return {"OpenBLAS", file, false};
  for (const std::string& file : loaded_libraries("libmkl")) return {"MKL", file, false};
  return {"no BLAS found", "", true};
}

std::vector<std::string> cpu_features() {
  std::vector<std::string> features;
#if defined(__x86_64__)
  const std::array<std::pair<const char*, bool>, 5> known{{{"sse4.2", __builtin_cpu_supports("sse4.2") != 0},
                                                           {"avx", __builtin_cpu_supports("avx") != 0},
                                                           {"avx2", __builtin_cpu_supports("avx2") != 0},
                                                           {"fma", __builtin_cpu_supports("fma") != 0},
                                                           {"avx512f", __builtin_cpu_supports("avx512f") != 0}}};
  for (const auto& [name, there] : known) {
    if (there) features.emplace_back(name);
  }
#endif
  return features;
}

/// The smallest step between two readings of the steady clock [ns].
double timer_step_ns() {
  auto smallest = Clock::duration::max();
  for (int i = 0; i < 2000; ++i) {
    const auto begin = Clock::now();
    auto next = begin;
    while (next == begin) next = Clock::now();
    smallest = std::min(smallest, next - begin);
  }
  return std::chrono::duration<double, std::nano>(smallest).count();
}

/// How late a sleep of 2 ms ends, the median of 50 [us]. A live detector has this delay.
double wake_up_delay_us() {
  std::vector<double> delays;
  for (int i = 0; i < 50; ++i) {
    const auto due = Clock::now() + std::chrono::milliseconds(2);
    std::this_thread::sleep_until(due);
    delays.push_back(std::chrono::duration<double, std::micro>(Clock::now() - due).count());
  }
  return median(delays);
}

/// Writes 64 MiB into `folder` and syncs them [MB/s]; nothing if it cannot. The file has no name while it is written, so that a
/// kill leaves nothing.
std::optional<double> disk_write_speed(const fs::path& folder) {
  std::string file = (folder / ".tactile-doctor-XXXXXX").string();
  const int out = ::mkostemp(file.data(), O_CLOEXEC);
  if (out < 0) return std::nullopt;
  ::unlink(file.c_str());
  std::vector<char> chunk(1 << 20);
  for (std::size_t i = 0; i < chunk.size(); ++i) chunk[i] = static_cast<char>(i * 2654435761U >> 24);
  constexpr int chunks = 64;
  const auto begin = Clock::now();
  bool written = true;
  for (int i = 0; i < chunks && written; ++i)
    written = ::write(out, chunk.data(), chunk.size()) == static_cast<ssize_t>(chunk.size());
  written = written && ::fsync(out) == 0;
  const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  ::close(out);
  return written ? std::optional(chunks * 1.048576 / seconds) : std::nullopt;
}

#ifdef TACTILE_HAS_LIBCAER
constexpr bool has_libcaer = true;
#else
constexpr bool has_libcaer = false;
#endif

/// What was found out about this machine.
struct Examination {
  fs::path folder;                    ///< whose disk was measured
  std::vector<std::string> warnings;  ///< in the order of the checks
  Blas blas;
  std::vector<std::string> features;  ///< of the CPU
  double step_ns = 0;                 ///< of the timer
  double delay_us = 0;                ///< of a wake-up
  std::optional<double> disk_mb_s;    ///< nothing if the folder cannot be written
};

Examination examine_machine(const fs::path& data) {
  Examination found;
  found.folder = fs::is_directory(data) ? data : fs::path(".");
  for (const auto load : {model::load_libtorch, video::load_picture_codec}) {
    try {
      load();
    } catch (const Error& e) {
      found.warnings.emplace_back(e.what());
    }
  }
  found.blas = blas_in_use();
  found.features = cpu_features();
  stop_if_interrupted();
  found.step_ns = timer_step_ns();
  found.delay_us = wake_up_delay_us();
  stop_if_interrupted();
  found.disk_mb_s = disk_write_speed(found.folder);
  stop_if_interrupted();

  if (found.blas.slow) {
    found.warnings.push_back(
        fmt::format("libtorch runs on {}, two to three times slower than OpenBLAS; install the package libopenblas0-pthread",
                    found.blas.name));
  }
  if (!found.disk_mb_s) {
    found.warnings.push_back(
        fmt::format("{} cannot be written; recordings and results need a writable folder", found.folder.string()));
  }
  if (found.disk_mb_s && *found.disk_mb_s < 100) {
    found.warnings.push_back(fmt::format("the disk under {} writes {:.0f} MB/s; a fast scene needs about 100 MB/s uncompressed",
                                         found.folder.string(), *found.disk_mb_s));
  }
  return found;
}

nlohmann::json machine_json(const Examination& found) {
  nlohmann::json versions;
  for (const LibraryVersion& library : library_versions()) versions[lower_case(library.name)] = library.version;
  return {{"version", version()},
          {"revision", revision()},
          {"libraries", versions},
          {"blas", {{"name", found.blas.name}, {"file", found.blas.file}}},
          {"cpu", {{"name", cpu_name()}, {"cores", std::thread::hardware_concurrency()}, {"features", found.features}}},
          {"timer_step_ns", found.step_ns},
          {"wake_up_delay_us", found.delay_us},
          {"disk_write_mb_per_s", found.disk_mb_s ? nlohmann::json(*found.disk_mb_s) : nlohmann::json(nullptr)},
          {"libcaer", has_libcaer},
          {"warnings", found.warnings}};
}

std::string machine_text(const Examination& found) {
  std::string text = fmt::format("tactile {} ({})\n\n", version(), revision());
  std::vector<std::pair<std::string, std::string>> lines{
      {"CPU", fmt::format("{}, {} cores", cpu_name(), std::thread::hardware_concurrency())},
      {"CPU features", fmt::format("{}", fmt::join(found.features, ", "))}};
  std::string libraries;
  for (const LibraryVersion& library : library_versions())
    libraries += fmt::format("{}{} {}", libraries.empty() ? "" : ", ", library.name, library.version);
  lines.emplace_back("libraries", libraries);
  lines.insert(lines.end(),
               {{"BLAS", found.blas.file.empty() ? found.blas.name : fmt::format("{} ({})", found.blas.name, found.blas.file)},
                {"timer step", fmt::format("{:.0f} ns", found.step_ns)},
                {"wake-up delay", fmt::format("{:.0f} µs after a sleep of 2 ms", found.delay_us)},
                {"disk write",
                 found.disk_mb_s ? fmt::format("{:.0f} MB/s in {}", *found.disk_mb_s, found.folder.string()) : "not writable"},
                {"camera driver", has_libcaer ? "libcaer" : "built without libcaer"}});
  text += text_list(lines);
  for (const std::string& warning : found.warnings) text += "\nwarning: " + warning + "\n";
  if (found.warnings.empty()) text += "\nNo problem was found.\n";
  return text;
}

void report_on_machine(const CommonArguments& common, const fs::path& data) {
  const Examination found = examine_machine(data);
  print_result(common, machine_json(found), machine_text(found));
}

}  // namespace

void add_doctor_command(CLI::App& app) {
  auto data = std::make_shared<std::string>("data");
  Command command = add_command(app, "doctor", "Check this machine: libraries, BLAS, CPU, timer, disk, camera",
                                [data](const CommonArguments& common) { report_on_machine(common, *data); });
  command.add_option("data", *data, "Folder whose disk is measured; the current folder if DATA does not exist").show_default();
}

}  // namespace tactile::cli
