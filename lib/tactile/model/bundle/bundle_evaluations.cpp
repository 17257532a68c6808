#include "tactile/model/bundle/bundle_evaluations.hpp"

#include <algorithm>
#include <cctype>
#include <string_view>
#include <system_error>

namespace tactile::model {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t digits = 8;
constexpr std::string_view begins = "eval-on-", ends = ".json";

/// Results with other options have more in their names.
bool is_of_usual_options(const std::string& name) {
  if (name == "eval.json") return true;
  if (name.size() != begins.size() + digits + ends.size() || !name.starts_with(begins) || !name.ends_with(ends)) return false;
  return std::all_of(name.begin() + begins.size(), name.end() - ends.size(),
                     [](unsigned char c) { return std::isxdigit(c) != 0; });
}

}  // namespace

fs::path evaluation_on(const ModelBundle& bundle, const std::string& learned_from, const std::string& judged_on) {
  if (learned_from == judged_on) return bundle.evaluation();
  return bundle.folder / (std::string(begins) + judged_on.substr(0, digits) + std::string(ends));
}

std::optional<fs::path> newest_evaluation(const ModelBundle& bundle) {
  std::optional<fs::path> newest;
  fs::file_time_type newest_time{};
  std::error_code failed;
  for (fs::directory_iterator entry(bundle.folder, failed), end; !failed && entry != end; entry.increment(failed)) {
    if (!is_of_usual_options(entry->path().filename().string())) continue;
    const auto time = fs::last_write_time(entry->path(), failed);
    if (!failed && (!newest || time > newest_time)) {
      newest = entry->path();
      newest_time = time;
    }
  }
  return newest;
}

}  // namespace tactile::model
