#include "tactile/model/bundle/bundle_evaluations.hpp"

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "tactile/core/json.hpp"

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

/// The member dataset.file; empty if it is not there.
std::string dataset_file_in(const fs::path& file) {
  try {
    const nlohmann::json json = read_json(file);
    return json.at("dataset").at("file").get<std::string>();
  } catch (const std::exception&) {
    return {};
  }
}

}  // namespace

fs::path evaluation_on(const ModelBundle& bundle, const std::string& learned_from, const std::string& judged_on) {
  if (learned_from == judged_on) return bundle.evaluation();
  return bundle.results() / (std::string(begins) + judged_on.substr(0, digits) + std::string(ends));
}

std::optional<fs::path> newest_evaluation(const ModelBundle& bundle) {
  std::vector<std::pair<fs::file_time_type, fs::path>> found;
  std::error_code failed;
  for (fs::directory_iterator entry(bundle.results(), failed), end; !failed && entry != end; entry.increment(failed)) {
    if (!is_of_usual_options(entry->path().filename().string())) continue;
    const auto time = fs::last_write_time(entry->path(), failed);
    if (!failed) found.emplace_back(time, entry->path());
  }
  if (found.empty()) return std::nullopt;
  if (found.size() == 1) return found.front().second;  // nothing to compare, so nothing to read
  std::sort(found.rbegin(), found.rend());
  const std::string learned_from = dataset_file_in(bundle.description());
  const auto of_its_data =
      std::find_if(found.begin(), found.end(), [&](const auto& one) { return dataset_file_in(one.second) == learned_from; });
  return of_its_data != found.end() ? of_its_data->second : found.front().second;
}

}  // namespace tactile::model
