#include "tactile/windows/write_dataset.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <mutex>
#include <optional>
#include <tuple>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/core/random.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/hdf5/hdf5_objects.hpp"
#include "tactile/labels/labels.hpp"
#include "tactile/windows/dataset.hpp"
#include "tactile/windows/dataset_layout.hpp"

namespace tactile {
namespace fs = std::filesystem;
namespace h5 = hdf5;

namespace {

/// A run as a dataset takes it.
struct PlannedRun {
  RunFolder folder;
  RunInfo info;
  WindowedRun outcome;
  std::string events_sha256, labels_sha256;
  SensorSize sensor;
  CameraTime first_event{}, last_event{};
  std::vector<TouchInterval> intervals;  ///< those whose labels are used
  std::vector<Sample> samples;           ///< `run_index` counts planned runs
};

struct Plan {
  std::vector<PlannedRun> runs;  ///< those in the dataset
  std::vector<WindowedRun> left_out;
  std::vector<std::string> warnings;
  SensorSize sensor;
  bool simulated = false;

  nlohmann::json settings;
  std::vector<DatasetRun> rows;  ///< of `runs`, their events not counted yet
  nlohmann::json manifest;
};

struct HalfOpenInterval {
  CameraTime begin{}, end{};
};

/// Opens a run's recording at its event stream.
struct OpenRun {
  explicit OpenRun(const RunFolder& run) : recording(run.events()), stream_id(event_stream(recording).id) {}
  RecordingReader recording;
  std::int32_t stream_id;
};

void find_ends(PlannedRun& run) {
  OpenRun open(run.folder);
  const std::string where = run.folder.events().string();
  run.sensor = open.recording.stream(open.stream_id).size.value_or(SensorSize{run.info.width, run.info.height});
  if (run.sensor != SensorSize{run.info.width, run.info.height}) {
    throw Error(where + ": of a sensor of " + std::to_string(run.sensor.width) + "x" + std::to_string(run.sensor.height) +
                " px; expected the " + std::to_string(run.info.width) + "x" + std::to_string(run.info.height) +
                " px that run.json has");
  }
  std::optional<CameraTime> last;
  for_all_events(open.recording, open.stream_id, [&](std::span<const Event> events) {
    for (const Event& event : events) {
      if (!last) run.first_event = event.t;
      if (last && event.t < *last) {
        throw Error(where + ": events go back in time at " + std::to_string(us_of(event.t)) +
                    " us; expected them in ascending order, as 'tactile repair' puts them");
      }
      last = event.t;
    }
  });
  if (!last) throw Error(where + ": holds no event; expected a recording of the run");
  run.last_event = *last;
}

std::string list_of(const std::vector<std::string>& names, std::string_view between_them = ", ") {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : std::string(between_them)) + name;
  return text;
}

void draw_samples(PlannedRun& run, const Labels& labels, const WindowsOptions& options) {
  std::vector<SampledInterval> intervals;
  std::vector<std::string> flagged;
  for (std::size_t i = 0; i < labels.intervals.size(); ++i) {
    const bool used = options.include_flagged || !labels.interval_is_flagged(i);
    intervals.push_back({labels.intervals[i].interval(), used});
    if (used) run.intervals.push_back(labels.intervals[i].interval());
    if (!used) flagged.push_back(std::string(name_of(labels.intervals[i].touch)) + " " + std::to_string(i));
  }
  const std::uint64_t seed = seed_for(options.sampling.seed, {"windows", run.folder.object, run.folder.run});
  run.samples = balanced_samples(0, intervals, run.first_event, run.last_event, seed, options.sampling);
  for (const Sample& sample : run.samples) ++run.outcome.samples[static_cast<std::size_t>(sample.touch)];

  std::vector<std::string> remarks;
  if (run.samples.empty()) {
    const auto offered = ticks_on_offer(intervals, run.first_event, run.last_event, options.sampling);
    std::vector<std::string> lacking;
    for (const Touch touch : all_touches) {
      if (offered[static_cast<std::size_t>(touch)] == 0) lacking.emplace_back(name_of(touch));
    }
    remarks.push_back("no samples, it lacks " + list_of(lacking, " and "));
  }
  if (!flagged.empty()) remarks.push_back("flagged and left out: " + list_of(flagged));
  run.outcome.remark = list_of(remarks, "; ");
}

void leave_out(Plan& plan, const PlannedRun& run, std::string why) {
  plan.left_out.push_back(run.outcome);
  plan.left_out.back().remark = std::move(why);
}

/// The labelled runs below `data` that may be used together; the others are named in the plan.
std::vector<PlannedRun> choose_runs(const fs::path& data, const WindowsOptions& options, Plan& plan) {
  std::vector<PlannedRun> found;
  for (RunFolder& folder : find_runs(data)) {
    PlannedRun run{.folder = std::move(folder),
                   .info = {},
                   .outcome = {},
                   .events_sha256 = {},
                   .labels_sha256 = {},
                   .sensor = {},
                   .intervals = {},
                   .samples = {}};
    run.info = read_run_info(run.folder);
    run.outcome.object = run.folder.object;
    run.outcome.run = run.folder.run;
    found.push_back(std::move(run));
  }
  if (found.empty())
    throw Error(data.string() + ": no runs; expected DATA/<object>/<run>/events.aedat4, as 'tactile simulate' makes them");
  const bool any_real = std::any_of(found.begin(), found.end(), [](const PlannedRun& run) { return !run.info.simulated; });
  std::vector<std::string> unlabelled, simulated;
  std::vector<PlannedRun> chosen;
  for (PlannedRun& run : found) {
    if (any_real && run.info.simulated && !options.mix) {
      leave_out(plan, run, "simulated, and there are real runs");
      simulated.push_back(run.folder.name());
    } else if (!fs::exists(run.folder.labels())) {
      leave_out(plan, run, "no labels.json");
      unlabelled.push_back(run.folder.name());
    } else {
      if (!run.info.complete)
        plan.warnings.push_back(run.folder.name() + ": run.json says that the recording was never closed; what is there is used");
      chosen.push_back(std::move(run));
    }
  }
  if (!simulated.empty())
    plan.warnings.push_back("simulated runs are left out since there are real ones (--mix takes both): " + list_of(simulated));
  if (chosen.empty()) {
    throw Error(data.string() + ": none of its " + std::to_string(unlabelled.size()) +
                (any_real && !simulated.empty() ? " real" : "") +
                " runs has labels; expected labels.json in each, run 'tactile label " + data.string() + "'");
  }
  if (!unlabelled.empty())
    plan.warnings.push_back("runs without labels are left out ('tactile label' makes them): " + list_of(unlabelled));
  return chosen;
}

/// Of all sizes the one that most runs have; the first such of equals.
SensorSize common_sensor(const std::vector<PlannedRun>& runs) {
  const auto runs_of = [&](SensorSize size) {
    return std::count_if(runs.begin(), runs.end(), [&](const PlannedRun& run) { return run.sensor == size; });
  };
  const SensorSize common = std::max_element(runs.begin(), runs.end(), [&](const PlannedRun& a, const PlannedRun& b) {
                              return runs_of(a.sensor) < runs_of(b.sensor);
                            })->sensor;
  for (const PlannedRun& run : runs) {
    if (run.sensor != common) {
      throw Error(run.folder.name() + ": of a sensor of " + std::to_string(run.sensor.width) + "x" +
                  std::to_string(run.sensor.height) + " px; expected the " + std::to_string(common.width) + "x" +
                  std::to_string(common.height) + " px of the other runs");
    }
  }
  return common;
}

/// A run's folder as the dataset keeps it: relative to the dataset's own where it lies below it.
std::string folder_name(const RunFolder& run, const fs::path& dataset) {
  const fs::path folder = fs::weakly_canonical(run.folder), base = fs::weakly_canonical(fs::absolute(dataset).parent_path());
  const fs::path relative = folder.lexically_relative(base);
  const bool below = !relative.empty() && *relative.begin() != "..";
  return (below ? relative : folder).string();
}

/// Whether the labels are of these events; true where they do not tell, as those that a person wrote.
bool made_from(const Labels& labels, const std::string& events_sha256) {
  const nlohmann::json inputs =
      labels.provenance.is_object() ? labels.provenance.value("inputs", nlohmann::json::object()) : nlohmann::json::object();
  return !inputs.is_object() || !inputs.contains("events.aedat4") || inputs.at("events.aedat4") == events_sha256;
}

Plan plan_dataset(const fs::path& data, const fs::path& file, const WindowsOptions& options, unsigned threads,
                  const ProgressCallback& progress) {
  check(options.sampling);
  Plan plan;
  std::vector<PlannedRun> chosen = choose_runs(data, options, plan);
  std::vector<std::string> flags(chosen.size());
  std::mutex guard;
  std::uint64_t done = 0;
  parallel_for(chosen.size(), threads, [&](std::size_t i) {
    PlannedRun& run = chosen[i];
    const Labels labels = read_labels(run.folder.labels());
    if (labels.run_is_flagged() && !options.include_flagged) {
      std::vector<std::string> reasons;
      for (const LabelFlag& flag : labels.flags) {
        if (!flag.interval_index && !flag.confirmed) reasons.push_back(flag.reason);
      }
      flags[i] = "flagged: " + list_of(reasons, "; ");
    } else if (run.events_sha256 = sha256_of_file(run.folder.events()); !made_from(labels, run.events_sha256)) {
      flags[i] = "its events have changed since it was labelled, run 'tactile label' again";
    } else {
      run.labels_sha256 = sha256_of_file(run.folder.labels());
      find_ends(run);
      draw_samples(run, labels, options);
    }
    const std::scoped_lock lock(guard);
    tell(progress, ++done, 2 * chosen.size(), run.folder.name());
  });
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    if (flags[i].empty()) {
      plan.runs.push_back(std::move(chosen[i]));
      continue;
    }
    plan.warnings.push_back(chosen[i].folder.name() + ": left out, " + flags[i] +
                            (flags[i].starts_with("flagged") ? " (--include-flagged takes it)" : ""));
    leave_out(plan, chosen[i], flags[i]);
  }
  if (plan.runs.empty())
    throw Error(data.string() + ": no run is left (" + list_of(plan.warnings, "; ") +
                "); expected a labelled one at least that is not flagged and has not changed since");
  plan.sensor = common_sensor(plan.runs);

  std::map<std::string, std::string> run_with;
  std::vector<std::string> lacking;
  bool any_samples = false;
  for (std::uint32_t index = 0; index < plan.runs.size(); ++index) {
    PlannedRun& run = plan.runs[index];
    for (Sample& sample : run.samples) sample.run_index = index;
    run.outcome.in_dataset = true;
    plan.simulated = plan.simulated || run.info.simulated;
    any_samples = any_samples || !run.samples.empty();
    if (!run.outcome.remark.empty()) lacking.push_back(run.folder.name() + ": " + run.outcome.remark);
    const auto [other, is_new] = run_with.emplace(run.events_sha256, run.folder.name());
    if (!is_new)
      plan.warnings.push_back(run.folder.name() + ": holds the same recording as " + other->second +
                              ", so a split may test on what it trained on");
    plan.rows.push_back({.object = run.folder.object,
                         .run = run.folder.run,
                         .folder = folder_name(run.folder, file),
                         .events_sha256 = run.events_sha256,
                         .labels_sha256 = run.labels_sha256});
  }
  if (!any_samples) {
    throw Error(data.string() + ": no run has ticks of none, press and slip (" + list_of(lacking, "; ") +
                "); expected at least one with all three");
  }
  plan.warnings.insert(plan.warnings.end(), lacking.begin(), lacking.end());
  plan.settings = {{"sampling", options.sampling}, {"mix", options.mix}, {"include_flagged", options.include_flagged}};
  plan.manifest = dataset_layout::manifest_of(plan.settings, plan.sensor, plan.simulated, plan.rows);
  return plan;
}

/// The union of [t - history, t) over a run's samples, as intervals that do not touch, ascending.
std::vector<HalfOpenInterval> histories_of(const std::vector<Sample>& samples, microseconds history) {
  std::vector<HalfOpenInterval> histories;
  for (const Sample& sample : samples) {
    const CameraTime begin = before(sample.t, history);
    if (!histories.empty() && begin <= histories.back().end) {
      histories.back().end = sample.t;
    } else {
      histories.push_back({begin, sample.t});
    }
  }
  return histories;
}

/// Hands over the events of a run that a dataset stores.
void for_stored_events(const PlannedRun& run, microseconds history, const std::function<void(std::span<const Event>)>& use) {
  const std::vector<HalfOpenInterval> histories = histories_of(run.samples, history);
  if (histories.empty()) return;
  OpenRun open(run.folder);
  std::size_t current = 0;
  std::vector<Event> kept;
  for_events_between(open.recording, open.stream_id, histories.front().begin, histories.back().end,
                     [&](std::span<const Event> events) {
                       kept.clear();
                       for (const Event& event : events) {
                         while (current < histories.size() && histories[current].end <= event.t) ++current;
                         if (current < histories.size() && event.t >= histories[current].begin) kept.push_back(event);
                       }
                       use(kept);
                     });
}

class EventColumns {
 public:
  EventColumns(hid_t group, std::string where) : where_(std::move(where)) {
    constexpr hsize_t rows_per_chunk = hsize_t{1} << 16;
    t_table_ = h5::create_table(group, "t_us", H5T_STD_I64LE, {}, rows_per_chunk, where_);
    x_table_ = h5::create_table(group, "x", H5T_STD_U16LE, {}, rows_per_chunk, where_);
    y_table_ = h5::create_table(group, "y", H5T_STD_U16LE, {}, rows_per_chunk, where_);
    on_table_ = h5::create_table(group, "on", H5T_STD_U8LE, {}, rows_per_chunk, where_);
  }

  void append(std::span<const Event> events) {
    for (const Event& event : events) {
      t_.push_back(us_of(event.t));
      x_.push_back(static_cast<std::uint16_t>(event.x));
      y_.push_back(static_cast<std::uint16_t>(event.y));
      on_.push_back(event.on);
    }
    appended_ += events.size();
    if (t_.size() >= std::size_t{1} << 20) flush();
  }

  void flush() {
    h5::append_rows(t_table_, H5T_NATIVE_INT64, t_.data(), t_.size(), where_);
    h5::append_rows(x_table_, H5T_NATIVE_UINT16, x_.data(), x_.size(), where_);
    h5::append_rows(y_table_, H5T_NATIVE_UINT16, y_.data(), y_.size(), where_);
    h5::append_rows(on_table_, H5T_NATIVE_UINT8, on_.data(), on_.size(), where_);
    t_.clear();
    x_.clear();
    y_.clear();
    on_.clear();
  }

  std::uint64_t appended() const { return appended_; }

 private:
  std::string where_;
  h5::Id t_table_, x_table_, y_table_, on_table_;
  std::vector<std::int64_t> t_;
  std::vector<std::uint16_t> x_, y_;
  std::vector<std::uint8_t> on_;
  std::uint64_t appended_ = 0;
};

/// Writes the file of events and counts them in the plan's rows.
std::uint64_t write_events(Plan& plan, const fs::path& file, const std::string& manifest_hash, microseconds history,
                           const ProgressCallback& progress) {
  const std::string where = file.string();
  h5::Id out = h5::create_file(file);
  std::uint64_t written = 0;
  {
    const h5::Id group = h5::create_group(out, "events", where);
    h5::write_attribute(group, "manifest_sha256", manifest_hash, where);
    EventColumns columns(group, where);
    for (std::size_t i = 0; i < plan.runs.size(); ++i) {
      plan.rows[i].first_event = columns.appended();
      for_stored_events(plan.runs[i], history, [&](std::span<const Event> events) { columns.append(events); });
      plan.rows[i].events = columns.appended() - plan.rows[i].first_event;
      tell(progress, plan.runs.size() + i + 1, 2 * plan.runs.size(), plan.runs[i].folder.name());
    }
    columns.flush();
    written = columns.appended();
  }
  out.close(where);
  return written;
}

template <class T, class Rows, class Get>
void write_column(hid_t file, const std::string& name, const Rows& rows, const std::string& where, Get get) {
  std::vector<T> values;
  for (const auto& row : rows) values.push_back(get(row));
  h5::write_table(file, name, values, where);
}

void write_tables(const Plan& plan, const fs::path& file, const std::string& events_file, const std::string& manifest_hash) {
  const std::string where = file.string();
  h5::Id out = h5::create_file(file);
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

  std::vector<DatasetInterval> intervals;
  std::vector<Sample> samples;
  for (std::uint32_t index = 0; index < plan.runs.size(); ++index) {
    for (const TouchInterval& interval : plan.runs[index].intervals) intervals.push_back({index, interval});
    samples.insert(samples.end(), plan.runs[index].samples.begin(), plan.runs[index].samples.end());
  }
  const auto value_of = [](Touch touch) { return static_cast<std::uint8_t>(touch); };
  write_column<std::uint32_t>(out, "intervals/run", intervals, where, [](const DatasetInterval& i) { return i.run_index; });
  write_column<std::uint8_t>(out, "intervals/class", intervals, where,
                             [&](const DatasetInterval& i) { return value_of(i.interval.touch); });
  write_column<std::int64_t>(out, "intervals/start_us", intervals, where,
                             [](const DatasetInterval& i) { return us_of(i.interval.start); });
  write_column<std::int64_t>(out, "intervals/end_us", intervals, where,
                             [](const DatasetInterval& i) { return us_of(i.interval.end); });
  write_column<std::uint32_t>(out, "samples/run", samples, where, [](const Sample& sample) { return sample.run_index; });
  write_column<std::int64_t>(out, "samples/t_us", samples, where, [](const Sample& sample) { return us_of(sample.t); });
  write_column<std::uint8_t>(out, "samples/label", samples, where, [&](const Sample& sample) { return value_of(sample.touch); });
  out.close(where);
}

std::string events_file_of(const fs::path& dataset) {
  const h5::Session session;
  return h5::linked_file(h5::open_file(dataset, false), "events");
}

/// Gives the dataset that is about to be replaced its events under another name, so that it stays whole until it goes.
void set_old_events_aside(const fs::path& file, const fs::path& events_file, const fs::path& old_events_file) {
  if (events_file_of(file) == old_events_file.filename()) return;  // a command that was ended half-way had come so far
  std::error_code failed;
  fs::remove(old_events_file, failed);
  fs::create_hard_link(events_file, old_events_file, failed);
  if (failed) {
    WholeFile copy(old_events_file);
    fs::copy_file(events_file, copy.path());
    copy.commit();
  }
  WholeFile relinked(file);
  fs::copy_file(file, relinked.path());
  h5::Id out = h5::open_file(relinked.path(), true);
  if (H5Ldelete(out, "events", H5P_DEFAULT) < 0) h5::fail_writing(file.string(), "its events cannot be set aside");
  h5::link_to_file(out, "events", old_events_file.filename().string(), "/events", file.string());
  out.close(file.string());
  relinked.commit();
}

void remove_stale_files(const fs::path& file) {
  std::vector<fs::path> stale{dataset_layout::file_beside(file, "events.old")};
  const std::string begin = file.stem().string() + ".th_";
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with(begin) && name.ends_with(".h5")) stale.push_back(entry.path());
  }
  std::error_code ignored;
  for (const fs::path& each : stale) fs::remove(each, ignored);
}

enum class Existing { nothing, dataset, broken_dataset };

/// @throws Error  if the file is there and no dataset of ours, which nobody asked to overwrite
Existing examine(const fs::path& file, std::optional<Dataset>& dataset) {
  if (!fs::exists(file)) return Existing::nothing;
  try {
    dataset.emplace(file);
    return Existing::dataset;
  } catch (const Error&) {
    const h5::Session session;
    const h5::Id id(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
    if (id >= 0 && h5::has_attribute(id, "manifest_sha256")) return Existing::broken_dataset;
  }
  throw Error(file.string() + ": is there and no dataset of tactile's; expected a dataset to replace, or no such file");
}

bool same_folders(std::span<const DatasetRun> a, std::span<const DatasetRun> b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const DatasetRun& x, const DatasetRun& y) { return x.folder == y.folder; });
}

DatasetSummary summary_of(const Plan& plan) {
  DatasetSummary summary{
      .runs = plan.left_out, .warnings = plan.warnings, .manifest_hash = hash_of(plan.manifest), .simulated = plan.simulated};
  for (const PlannedRun& run : plan.runs) {
    summary.runs.push_back(run.outcome);
    summary.samples += run.samples.size();
  }
  std::sort(summary.runs.begin(), summary.runs.end(),
            [](const WindowedRun& a, const WindowedRun& b) { return std::tie(a.object, a.run) < std::tie(b.object, b.run); });
  return summary;
}

std::string digest_of(const std::vector<Event>& events) {
  Sha256 digest;
  for (const Event& event : events) {
    const std::array<std::int64_t, 4> fields{us_of(event.t), event.x, event.y, event.on};
    digest.add(std::as_bytes(std::span(fields)));
  }
  return digest.hex();
}

/// What differs between one run of a dataset and what its folder gives now.
void compare_run(const Dataset& dataset, std::uint32_t stored_index, const PlannedRun& run, const DatasetRun& row,
                 std::vector<std::string>& differences) {
  const DatasetRun& stored = dataset.runs()[stored_index];
  const std::string name = run.folder.name();
  if (stored.events_sha256 != row.events_sha256)
    differences.push_back(name + ": events.aedat4 has changed since the dataset was made");
  if (stored.labels_sha256 != row.labels_sha256)
    differences.push_back(name + ": labels.json has changed since the dataset was made");

  std::vector<Sample> samples;
  for (Sample sample : dataset.samples()) {
    if (sample.run_index != stored_index) continue;
    sample.run_index = run.samples.empty() ? 0 : run.samples.front().run_index;
    samples.push_back(sample);
  }
  if (samples != run.samples) {
    const auto [a, b] = std::mismatch(samples.begin(), samples.end(), run.samples.begin(), run.samples.end());
    const auto text_of = [](const std::vector<Sample>& of, auto at) {
      return at == of.end() ? std::string("nothing")
                            : std::string(name_of(at->touch)) + " at " + std::to_string(us_of(at->t)) + " us";
    };
    differences.push_back(name + ": sample " + std::to_string(a - samples.begin()) + " is " + text_of(samples, a) +
                          ", its runs and labels give " + text_of(run.samples, b));
  }
  std::vector<TouchInterval> intervals;
  for (const DatasetInterval& interval : dataset.intervals()) {
    if (interval.run_index == stored_index) intervals.push_back(interval.interval);
  }
  const bool same_intervals = std::equal(
      intervals.begin(), intervals.end(), run.intervals.begin(), run.intervals.end(),
      [](const TouchInterval& a, const TouchInterval& b) { return a.touch == b.touch && a.start == b.start && a.end == b.end; });
  if (!same_intervals) differences.push_back(name + ": its intervals are not those of its labels");

  std::vector<Event> expected;
  for_stored_events(run, dataset.sampling().history,
                    [&](std::span<const Event> events) { expected.insert(expected.end(), events.begin(), events.end()); });
  if (expected != dataset.events(stored_index))
    differences.push_back(name + ": its events are not those of its samples' histories");
}

}  // namespace

DatasetSummary write_dataset(const fs::path& data, const fs::path& file, const WindowsOptions& options, unsigned threads,
                             const ProgressCallback& progress) {
  std::optional<Dataset> old;
  const Existing existing = examine(file, old);
  Plan plan = plan_dataset(data, file, options, threads, progress);
  DatasetSummary summary = summary_of(plan);
  const fs::path events_file = dataset_layout::file_beside(file, "events");
  if (existing == Existing::dataset && old->manifest_hash() == summary.manifest_hash && same_folders(old->runs(), plan.rows) &&
      events_file_of(file) == events_file.filename()) {
    summary.outcome = DatasetSummary::Outcome::unchanged;
    for (const DatasetRun& run : old->runs()) summary.events += run.events;
    return summary;
  }
  old.reset();

  const h5::Session session;
  WholeFile events(events_file);
  summary.events = write_events(plan, events.path(), summary.manifest_hash, options.sampling.history, progress);
  const dataset_layout::FolderLock lock(file);
  if (existing == Existing::dataset) set_old_events_aside(file, events_file, dataset_layout::file_beside(file, "events.old"));
  WholeFile tables(file);
  write_tables(plan, tables.path(), events_file.filename().string(), summary.manifest_hash);
  events.commit();
  tables.commit();
  if (existing != Existing::nothing) {
    summary.outcome = DatasetSummary::Outcome::replaced;
    remove_stale_files(file);
  }
  return summary;
}

std::vector<std::string> verify_dataset(const fs::path& data, const fs::path& file, unsigned threads,
                                        const ProgressCallback& progress) {
  const Dataset dataset(file);
  const WindowsOptions options{.sampling = dataset.sampling(),
                               .mix = member<bool>(dataset.settings(), "mix", file.string()),
                               .include_flagged = member<bool>(dataset.settings(), "include_flagged", file.string())};
  const Plan plan = plan_dataset(data, file, options, threads, progress);
  std::vector<std::string> differences;
  if (dataset.sensor() != plan.sensor) differences.emplace_back("the sensor's size is not that of the runs");
  if (dataset.simulated() != plan.simulated) differences.emplace_back("what the dataset says of simulated runs is not so");
  std::map<std::string, std::uint32_t> stored;
  for (std::uint32_t index = 0; index < dataset.runs().size(); ++index) {
    stored.emplace(dataset.runs()[index].object + "/" + dataset.runs()[index].run, index);
  }
  for (std::size_t i = 0; i < plan.runs.size(); ++i) {
    const PlannedRun& run = plan.runs[i];
    const auto found = stored.find(run.folder.name());
    if (found == stored.end()) {
      differences.push_back(run.folder.name() + ": is among the runs but not in the dataset");
      continue;
    }
    compare_run(dataset, found->second, run, plan.rows[i], differences);
    stored.erase(found);
    tell(progress, plan.runs.size() + i + 1, 2 * plan.runs.size(), run.folder.name());
  }
  for (const auto& [name, index] : stored)
    differences.push_back(name + ": is in the dataset but no longer among the runs to use");

  std::map<std::string, std::string> run_of_file, run_of_events;
  for (std::uint32_t index = 0; index < dataset.runs().size(); ++index) {
    const DatasetRun& run = dataset.runs()[index];
    const std::string name = run.object + "/" + run.run;
    const auto [same_file, new_file] = run_of_file.emplace(run.events_sha256, name);
    if (!new_file) {
      differences.push_back(name + ": holds the same recording as " + same_file->second +
                            ", so training windows lie in test windows");
      continue;
    }
    if (run.events == 0) continue;
    const auto [same_events, new_events] = run_of_events.emplace(digest_of(dataset.events(index)), name);
    if (!new_events)
      differences.push_back(name + ": holds the same events as " + same_events->second +
                            ", so training windows lie in test windows");
  }
  return differences;
}

}  // namespace tactile
