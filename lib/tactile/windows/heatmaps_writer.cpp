#include <cassert>
#include <optional>
#include <string>
#include <system_error>

#include "tactile/core/error.hpp"
#include "tactile/core/folder_lock.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/hdf5/hdf5_objects.hpp"
#include "tactile/windows/dataset.hpp"
#include "tactile/windows/dataset_layout.hpp"
#include "tactile/windows/run_samples.hpp"

namespace tactile::windows {
namespace fs = std::filesystem;
namespace h5 = hdf5;

struct HeatmapsWriter::State {
  fs::path dataset;
  std::string manifest_hash;
  StoredHeatmaps description;
  std::uint64_t samples = 0, written = 0, digested = 0;  ///< `digested`: bytes
  fs::path target;
  std::optional<WholeFile> whole;
  h5::Id file, table;
  Sha256 digest;

  std::size_t heatmap_size() const {
    return static_cast<std::size_t>(description.width) * static_cast<std::size_t>(description.height);
  }

  ~State() {
    const h5::Session session;
    table = {};
    file = {};
  }
};

HeatmapsWriter::HeatmapsWriter(const Dataset& dataset, const StoredHeatmaps& description) : state_(std::make_unique<State>()) {
  const h5::Session session;
  state_->dataset = dataset.file();
  state_->manifest_hash = dataset.manifest_hash();
  state_->description = description;
  state_->samples = dataset.samples().size();
  state_->target = dataset_layout::file_beside(dataset.file(), description.name);
  state_->whole.emplace(state_->target, IfThere::replace);
  const std::string where = state_->target.string();
  state_->file = h5::create_file(state_->whole->path(), h5::Structure::checked);
  // Each heatmap is one chunk, so that reading a sample reads no other.
  state_->table = h5::create_table(state_->file, description.name, H5T_STD_U8LE,
                                   {static_cast<hsize_t>(description.height), static_cast<hsize_t>(description.width)}, 1, where);
  h5::write_attribute(state_->table, "manifest_sha256", state_->manifest_hash, where);
  h5::write_attribute(state_->table, "settings", description.settings.dump(), where);
  for (const auto& [key, value] : description.settings.items()) {
    if (value.is_number_integer()) h5::write_attribute(state_->table, key, value.get<std::int64_t>(), where);
    if (value.is_number_float()) h5::write_attribute(state_->table, key, value.get<double>(), where);
    if (value.is_string()) h5::write_attribute(state_->table, key, value.get<std::string>(), where);
  }
  const h5::Id sources = h5::create_group(state_->file, dataset_layout::sources, where);
  std::vector<std::string> hashes;
  std::vector<std::uint64_t> counts;
  for (const RunSamples& run : samples_by_run(dataset)) {
    hashes.push_back(source_sha256_of(dataset, run));
    counts.push_back(run.count);
  }
  h5::write_table(sources, "sha256", hashes, where);
  h5::write_table(sources, "samples", counts, where);
}

HeatmapsWriter::~HeatmapsWriter() = default;

HeatmapsWriter::Packed HeatmapsWriter::packed(std::vector<std::uint8_t> heatmaps) const {
  Packed packed{std::move(heatmaps), {}};
  const std::span<const std::uint8_t> all(packed.heatmaps);
  const std::size_t size = state_->heatmap_size();
  for (std::size_t at = 0; at + size <= all.size(); at += size) packed.chunks.push_back(h5::packed_chunk(all.subspan(at, size)));
  return packed;
}

HeatmapsWriter::Packed HeatmapsWriter::unpacked(std::vector<std::vector<std::uint8_t>> chunks) const {
  Packed packed{{}, std::move(chunks)};
  packed.heatmaps.reserve(packed.chunks.size() * state_->heatmap_size());
  for (const std::vector<std::uint8_t>& chunk : packed.chunks) {
    const std::vector<std::uint8_t> heatmap = h5::unpacked_chunk(chunk, state_->heatmap_size(), state_->target.string());
    packed.heatmaps.insert(packed.heatmaps.end(), heatmap.begin(), heatmap.end());
  }
  return packed;
}

void HeatmapsWriter::add_to_digest(std::span<const std::uint8_t> heatmaps) {
  state_->digest.add(std::as_bytes(heatmaps));
  state_->digested += heatmaps.size();
}

void HeatmapsWriter::append(std::span<const std::vector<std::uint8_t>> chunks) {
  const h5::Session session;
  h5::append_packed_rows(state_->table, chunks, state_->target.string());
  state_->written += chunks.size();
}

void HeatmapsWriter::commit() {
  const h5::Session session;
  const std::string where = state_->target.string(), name = state_->description.name;
  if (state_->written != state_->samples) {
    throw Error(where + ": " + std::to_string(state_->written) + " heatmaps; expected one for each of " +
                std::to_string(state_->samples) + " samples");
  }
  assert(state_->digested == state_->samples * state_->heatmap_size());  // `add_to_digest` for each `append`
  h5::write_attribute(state_->table, "sha256", state_->digest.hex(), where);
  state_->table.close(where);
  state_->file.close(where);

  const FolderLock lock(dataset_layout::folder_of(state_->dataset));
  WholeFile copy(state_->dataset, IfThere::replace);
  std::error_code failed;
  fs::copy_file(state_->dataset, copy.path(), failed);
  if (failed)
    throw Error(state_->dataset.string() + ": cannot be copied (" + failed.message() + "); expected a folder with room");
  h5::Id linked = h5::open_file(copy.path(), true);
  if (h5::read_text_attribute(linked, "manifest_sha256", state_->dataset.string()) != state_->manifest_hash) {
    throw Error(state_->dataset.string() +
                ": was replaced by another dataset while heatmaps were rendered; run the command again");
  }
  h5::Id group(H5Gopen2(linked, "heatmaps", H5P_DEFAULT), H5Gclose);
  if (group < 0) h5::fail(state_->dataset.string(), "/heatmaps cannot be opened");
  state_->whole->commit();
  if (h5::has_member(group, name)) return;  // another process has made the same
  h5::link_to_file(group, name, state_->target.filename().string(), name, state_->dataset.string());
  group.close(where);
  linked.close(where);
  copy.commit();
}

}  // namespace tactile::windows
