#include "tactile/windows/write_dataset.hpp"

#include <algorithm>
#include <optional>
#include <set>
#include <tuple>

#include "tactile/core/error.hpp"
#include "tactile/core/folder_lock.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/hdf5/hdf5_objects.hpp"
#include "tactile/windows/dataset.hpp"
#include "tactile/windows/dataset_layout.hpp"
#include "tactile/windows/dataset_plan.hpp"
#include "tactile/windows/older_dataset.hpp"
#include "tactile/windows/older_heatmaps.hpp"
#include "tactile/windows/run_samples.hpp"
#include "tactile/windows/write_events.hpp"

namespace tactile::windows {
namespace fs = std::filesystem;
namespace h5 = hdf5;

namespace {

EventSources sources_of(const DatasetPlan& plan, const OlderDataset* older, microseconds history) {
  EventSources sources{.older = older, .kept = {}, .history = history};
  sources.kept.resize(plan.runs.size());
  for (std::size_t i = 0; older != nullptr && i < plan.runs.size(); ++i)
    sources.kept[i] = older->with_same_events(plan.runs[i].events_sha256, plan.runs[i].samples, history);
  return sources;
}

template <class T, class Rows, class Get>
void write_column(hid_t file, const std::string& name, const Rows& rows, const std::string& where, Get get) {
  std::vector<T> values;
  values.reserve(rows.size());
  for (const auto& row : rows) values.push_back(get(row));
  h5::write_table(file, name, values, where);
}

void write_tables(const DatasetPlan& plan, const fs::path& file, const std::string& events_file,
                  const std::string& manifest_hash) {
  const std::string where = file.string();
  h5::Id out = h5::create_file(file, h5::Structure::checked);
  h5::write_attribute(out, "format", dataset_layout::format, where);
  h5::write_attribute(out, "manifest_sha256", manifest_hash, where);
  h5::write_attribute(out, "settings", plan.settings.dump(), where);
  h5::write_attribute(out, "simulated", std::int64_t{plan.simulated}, where);
  h5::write_attribute(out, "sensor_width", std::int64_t{plan.sensor.width}, where);
  h5::write_attribute(out, "sensor_height", std::int64_t{plan.sensor.height}, where);
  for (const char* group : {"runs", "intervals", "samples", "heatmaps"}) h5::create_group(out, group, where);
  h5::link_to_file(out, "events", events_file, "/events", where);

  write_column<std::string>(out, "runs/object", plan.rows, where, [](const DatasetRun& run) { return run.object; });
  write_column<std::string>(out, "runs/run", plan.rows, where, [](const DatasetRun& run) { return run.run; });
  write_column<std::string>(out, "runs/folder", plan.rows, where, [](const DatasetRun& run) { return run.folder; });
  write_column<std::uint64_t>(out, "runs/first_event", plan.rows, where, [](const DatasetRun& run) { return run.first_event; });
  write_column<std::uint64_t>(out, "runs/events", plan.rows, where, [](const DatasetRun& run) { return run.events; });
  write_column<std::string>(out, "runs/events_sha256", plan.rows, where, [](const DatasetRun& run) { return run.events_sha256; });
  write_column<std::string>(out, "runs/labels_sha256", plan.rows, where, [](const DatasetRun& run) { return run.labels_sha256; });
  write_column<std::int64_t>(out, "runs/first_us", plan.rows, where,
                             [](const DatasetRun& run) { return us_of(run.recording->first); });
  write_column<std::int64_t>(out, "runs/last_us", plan.rows, where,
                             [](const DatasetRun& run) { return us_of(run.recording->last); });
  write_column<std::string>(out, "runs/event_digest", plan.rows, where,
                            [](const DatasetRun& run) { return run.recording->digest; });

  std::vector<DatasetInterval> intervals;
  for (std::uint32_t index = 0; index < plan.runs.size(); ++index) {
    for (const TouchInterval& interval : plan.runs[index].intervals) intervals.push_back({index, interval});
  }
  // There are many samples, so no second list of them is made.
  const auto write_samples = [&]<class T>(const std::string& name, T, const auto& get) {
    std::vector<T> values;
    for (const PlannedRun& run : plan.runs) {
      for (const Sample& sample : run.samples) values.push_back(get(sample));
    }
    h5::write_table(out, name, values, where);
  };
  const auto value_of = [](Touch touch) { return static_cast<std::uint8_t>(touch); };
  write_column<std::uint32_t>(out, "intervals/run", intervals, where, [](const DatasetInterval& i) { return i.run_index; });
  write_column<std::uint8_t>(out, "intervals/class", intervals, where,
                             [&](const DatasetInterval& i) { return value_of(i.interval.touch); });
  write_column<std::int64_t>(out, "intervals/start_us", intervals, where,
                             [](const DatasetInterval& i) { return us_of(i.interval.start); });
  write_column<std::int64_t>(out, "intervals/end_us", intervals, where,
                             [](const DatasetInterval& i) { return us_of(i.interval.end); });
  write_samples("samples/run", std::uint32_t{}, [](const Sample& sample) { return sample.run_index; });
  write_samples("samples/t_us", std::int64_t{}, [](const Sample& sample) { return us_of(sample.t); });
  write_samples("samples/label", std::uint8_t{}, [&](const Sample& sample) { return value_of(sample.touch); });
  out.close(where);
}

/// Renames the events of the dataset that is about to be replaced, so that it stays complete until then.
void set_old_events_aside(const fs::path& file, const fs::path& events_file, const fs::path& old_events_file) {
  if (events_file_of(file) == old_events_file.filename()) return;  // an interrupted command has already done this
  std::error_code failed;
  fs::remove(old_events_file, failed);
  fs::create_hard_link(events_file, old_events_file, failed);
  if (failed) {
    WholeFile copy(old_events_file, IfThere::replace);
    fs::copy_file(events_file, copy.path());
    copy.commit();
  }
  WholeFile relinked(file, IfThere::replace);
  fs::copy_file(file, relinked.path());
  h5::Id out = h5::open_file(relinked.path(), true);
  if (H5Ldelete(out, "events", H5P_DEFAULT) < 0) h5::fail_writing(file.string(), "its events cannot be set aside");
  h5::link_to_file(out, "events", old_events_file.filename().string(), "/events", file.string());
  out.close(file.string());
  relinked.commit();
}

/// Removes the events of the replaced dataset, and the files of histories without a link in the dataset from which no run can be
/// taken.
void remove_stale_files(const fs::path& file) {
  std::set<fs::path> in_use;
  {
    const h5::Session session;
    const h5::Id dataset = h5::open_file(file, false);
    in_use.insert(h5::linked_file(dataset, "events"));
    const h5::Id heatmaps = h5::open_group(dataset, "heatmaps", file.string());
    for (const std::string& name : h5::members_of(heatmaps)) in_use.insert(h5::linked_file(heatmaps, name));
  }
  const std::string begin = file.stem().string() + ".th_",
                    old_events = dataset_layout::file_beside(file, "events.old").filename();
  std::vector<fs::path> stale, histories;
  for (const fs::directory_entry& entry : fs::directory_iterator(dataset_layout::folder_of(file))) {
    const std::string name = entry.path().filename().string();
    if (in_use.contains(name)) continue;
    if (name == old_events) stale.push_back(entry.path());
    if (name.starts_with(begin) && name.ends_with(".h5")) histories.push_back(entry.path());
  }
  if (!histories.empty()) {
    const Dataset dataset(file);
    std::set<std::string> sources;
    for (const RunSamples& run : samples_by_run(dataset)) sources.insert(source_sha256_of(dataset, run));
    for (const fs::path& each : histories) {
      if (!lists_a_source(each, sources)) stale.push_back(each);
    }
  }
  std::error_code ignored;
  for (const fs::path& each : stale) fs::remove(each, ignored);
}

/// Updates the folders of the runs; the rest of the dataset stays.
void update_folders(const fs::path& file, std::span<const DatasetRun> rows, const std::string& manifest_hash) {
  const std::string where = file.string();
  const h5::Session session;
  WholeFile copy(file, IfThere::replace);
  fs::copy_file(file, copy.path());
  h5::Id out = h5::open_file(copy.path(), true);
  if (h5::read_text_attribute(out, "manifest_sha256", where) != manifest_hash)
    throw Error(where + ": was replaced by another dataset meanwhile; run the command again");
  if (H5Ldelete(out, "runs/folder", H5P_DEFAULT) < 0) h5::fail_writing(where, "the folders of its runs cannot be written");
  write_column<std::string>(out, "runs/folder", rows, where, [](const DatasetRun& run) { return run.folder; });
  out.close(where);
  copy.commit();
}

enum class Existing { nothing, dataset, broken_dataset };

/// @throws Error  if the file exists and is not a dataset
Existing examine(const fs::path& file, std::optional<Dataset>& dataset) {
  if (!fs::exists(file)) return Existing::nothing;
  try {
    dataset.emplace(file);
    return Existing::dataset;
  } catch (const Error&) {
    const h5::Session session;
    try {
      if (h5::has_attribute(h5::open_file(file, false), "manifest_sha256")) return Existing::broken_dataset;
    } catch (const h5::Damaged&) {
      if (fs::exists(dataset_layout::file_beside(file, "events"))) return Existing::broken_dataset;  // which belongs to it
    }
  }
  throw Error(file.string() + ": exists and is not a dataset of tactile; expected a dataset to replace, or a new name");
}

bool same_folders(std::span<const DatasetRun> a, std::span<const DatasetRun> b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const DatasetRun& x, const DatasetRun& y) { return x.folder == y.folder; });
}

/// A dataset of an earlier version does not; it is made again.
bool knows_recordings(const Dataset& dataset) {
  return std::all_of(dataset.runs().begin(), dataset.runs().end(), [](const DatasetRun& run) { return run.recording; });
}

DatasetSummary summary_of(const DatasetPlan& plan) {
  DatasetSummary summary;
  summary.runs = plan.left_out;
  summary.misnamed = plan.misnamed;
  summary.warnings = plan.warnings;
  summary.errors = plan.errors;
  summary.manifest_hash = hash_of(plan.manifest);
  summary.simulated = plan.simulated;
  for (const PlannedRun& run : plan.runs) {
    summary.runs.push_back(run.outcome);
    summary.samples += run.samples.size();
  }
  std::sort(summary.runs.begin(), summary.runs.end(),
            [](const WindowedRun& a, const WindowedRun& b) { return std::tie(a.object, a.run) < std::tie(b.object, b.run); });
  return summary;
}

std::vector<std::string> in_order(std::vector<std::string> names) {
  std::sort(names.begin(), names.end());
  return names;
}

/// What a dataset is made of, and where.
struct Making {
  fs::path data, file;
  WindowsOptions options;
  unsigned threads = 0;
  ProgressCallback progress;
};

/// Makes the dataset in the place of the one in `old`, if there is one. @param reuse  takes runs from it
/// @throws UnusableDataset  if they cannot be taken; the old dataset then stays
DatasetSummary make_dataset(const Making& making, Existing existing, std::optional<Dataset>& old, bool reuse) {
  const fs::path& file = making.file;
  const microseconds history = making.options.sampling.history;
  const std::optional<OlderDataset> older = old && reuse ? std::optional<OlderDataset>(*old) : std::nullopt;
  DatasetPlan plan = plan_dataset(making.data, file, making.options, making.threads, making.progress, older ? &*older : nullptr);
  DatasetSummary summary = summary_of(plan);
  const fs::path events_file = dataset_layout::file_beside(file, "events");
  remove_leftovers(file);
  remove_leftovers(events_file);
  if (old && old->manifest_hash() == summary.manifest_hash && events_file_of(file) == events_file.filename() &&
      knows_recordings(*old)) {
    for (const DatasetRun& run : old->runs()) summary.events += run.events;
    summary.read_runs = in_order(plan.read_runs);
    const bool moved = !same_folders(old->runs(), plan.rows);
    summary.outcome = moved ? DatasetSummary::Outcome::moved : DatasetSummary::Outcome::unchanged;
    const FolderLock lock(dataset_layout::folder_of(file));
    if (moved) update_folders(file, plan.rows, summary.manifest_hash);
    remove_stale_files(file);  // an interrupted command may have left some
    return summary;
  }
  const EventSources sources = sources_of(plan, older ? &*older : nullptr, history);
  WholeFile events(events_file, IfThere::replace);
  summary.events = write_events(plan, sources, events.path(), summary.manifest_hash, making.threads, making.progress);
  const h5::Session session;
  if (older) {
    std::vector<bool> same_events;
    for (const auto& same : sources.kept) same_events.push_back(same.has_value());
    summary.changes = changes_between(*old, plan.rows, same_events);
  }
  old.reset();
  summary.read_runs = in_order(plan.read_runs);
  const FolderLock lock(dataset_layout::folder_of(file));
  if (existing == Existing::dataset) set_old_events_aside(file, events_file, dataset_layout::file_beside(file, "events.old"));
  WholeFile tables(file, IfThere::replace);
  write_tables(plan, tables.path(), events_file.filename().string(), summary.manifest_hash);
  events.commit();
  tables.commit();
  if (existing != Existing::nothing) summary.outcome = DatasetSummary::Outcome::replaced;
  summary.was_damaged = existing == Existing::broken_dataset;
  remove_stale_files(file);
  return summary;
}

}  // namespace

DatasetSummary write_dataset(const fs::path& data, const fs::path& file, const WindowsOptions& options, unsigned threads,
                             const ProgressCallback& progress) {
  const Making making{.data = data, .file = file, .options = options, .threads = threads, .progress = progress};
  std::optional<Dataset> old;
  const Existing existing = examine(file, old);
  try {
    return make_dataset(making, existing, old, true);
  } catch (const UnusableDataset& e) {
    DatasetSummary summary = make_dataset(making, existing, old, false);
    summary.warnings.push_back("the runs of the previous dataset cannot be kept, all runs were read again: " +
                               std::string(e.what()));
    return summary;
  }
}

}  // namespace tactile::windows
