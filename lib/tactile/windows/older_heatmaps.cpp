#include "tactile/windows/older_heatmaps.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/hdf5/hdf5_objects.hpp"
#include "tactile/windows/dataset_layout.hpp"

namespace tactile::windows {
namespace fs = std::filesystem;
namespace h5 = hdf5;

namespace {

struct Rows {
  std::uint64_t first = 0, count = 0;
};

/// The rows of each source; empty if the file does not list them.
std::map<std::string, Rows> rows_by_source(hid_t file, const std::string& where) {
  std::map<std::string, Rows> rows;
  if (!h5::has_member(file, dataset_layout::sources)) return rows;
  const std::string group = std::string(dataset_layout::sources) + "/";
  const auto sources = h5::read_texts(file, group + "sha256", where);
  const auto samples = h5::read_table<std::uint64_t>(file, group + "samples", where);
  if (sources.size() != samples.size())
    throw Error(where + ": its list of runs has columns of different lengths; expected a file that tactile made");
  std::uint64_t next = 0;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    rows.emplace(sources[i], Rows{next, samples[i]});
    if (__builtin_add_overflow(next, samples[i], &next)) throw Error(where + ": lists too many samples");
  }
  return rows;
}

}  // namespace

struct OlderHeatmaps::State {
  std::string where;
  h5::Id file, table;
  std::map<std::string, Rows> rows;

  ~State() {
    const h5::Session session;
    table = {};
    file = {};
  }
};

OlderHeatmaps::OlderHeatmaps(std::unique_ptr<State> state) : state_(std::move(state)) {}
OlderHeatmaps::~OlderHeatmaps() = default;
OlderHeatmaps::OlderHeatmaps(OlderHeatmaps&&) noexcept = default;
OlderHeatmaps& OlderHeatmaps::operator=(OlderHeatmaps&&) noexcept = default;

std::optional<OlderHeatmaps> OlderHeatmaps::find(const fs::path& dataset, const StoredHeatmaps& wanted) {
  const fs::path path = dataset_layout::file_beside(dataset, wanted.name);
  if (!fs::exists(path)) return std::nullopt;
  const h5::Session session;
  auto state = std::make_unique<State>();
  state->where = path.string();
  state->file = h5::open_file(path, false);
  if (!h5::has_member(state->file, wanted.name)) return std::nullopt;
  state->table = h5::open_table(state->file, wanted.name, state->where);
  state->rows = rows_by_source(state->file, state->where);
  const std::vector<hsize_t> shape = h5::shape_of(state->table, state->where);
  const bool same_shape = shape.size() == 3 && shape[1] == static_cast<hsize_t>(wanted.height) &&
                          shape[2] == static_cast<hsize_t>(wanted.width) && h5::rows_per_chunk(state->table, state->where) == 1;
  std::uint64_t rows = 0;
  for (const auto& [source, of_source] : state->rows) rows = std::max(rows, of_source.first + of_source.count);
  if (state->rows.empty() || !same_shape || rows > shape[0]) return std::nullopt;
  const auto settings = nlohmann::json::parse(h5::read_text_attribute(state->table, "settings", state->where), nullptr, false);
  if (settings != wanted.settings) return std::nullopt;
  return OlderHeatmaps(std::move(state));
}

std::vector<std::vector<std::uint8_t>> OlderHeatmaps::chunks_of(const std::string& source_sha256) const {
  const auto found = state_->rows.find(source_sha256);
  std::vector<std::vector<std::uint8_t>> chunks;
  if (found == state_->rows.end()) return chunks;
  const h5::Session session;
  for (std::uint64_t i = 0; i < found->second.count; ++i)
    chunks.push_back(h5::read_packed_chunk(state_->table, found->second.first + i, state_->where));
  return chunks;
}

bool lists_a_source(const fs::path& heatmaps, const std::set<std::string>& sources) {
  const h5::Session session;
  try {
    const auto rows = rows_by_source(h5::open_file(heatmaps, false), heatmaps.string());
    return std::any_of(rows.begin(), rows.end(), [&](const auto& row) { return sources.contains(row.first); });
  } catch (const Error&) {
    return false;
  }
}

}  // namespace tactile::windows
