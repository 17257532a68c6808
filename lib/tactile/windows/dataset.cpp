#include "tactile/windows/dataset.hpp"

#include <algorithm>
#include <numeric>
#include <optional>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/text_lines.hpp"
#include "tactile/hdf5/hdf5_objects.hpp"
#include "tactile/hdf5/packed_rows.hpp"
#include "tactile/labels/labels.hpp"
#include "tactile/windows/dataset_layout.hpp"

namespace tactile::windows {
namespace fs = std::filesystem;
namespace h5 = hdf5;

namespace {

constexpr hsize_t largest_side = 32767;  // of a heatmap [px]

nlohmann::json parsed(const std::string& text, const std::string& where) {
  nlohmann::json settings = nlohmann::json::parse(text, nullptr, false);
  if (settings.is_discarded()) throw Error(where + ": its settings are not JSON; expected a file that tactile made");
  if (!settings.is_object()) throw Error(where + ": its settings are not an object; expected a file that tactile made");
  return settings;
}

[[noreturn]] void throw_inconsistent(const std::string& where, const std::string& what) {
  throw Error(where + ": " + what + "; expected a dataset as 'tactile windows' makes it");
}

/// @throws Error  unless all columns have the length of the first
template <class First, class... Others>
std::size_t common_length(const std::string& where, const First& first, const Others&... others) {
  if (((others.size() != first.size()) || ...)) throw_inconsistent(where, "columns differ in length");
  return first.size();
}

Touch touch_of(std::uint8_t value, const std::string& where) {
  if (value >= touch_count) throw_inconsistent(where, "class " + std::to_string(value) + " is not 0, 1 or 2");
  return static_cast<Touch>(value);
}

/// @param columns  t_us, x, y, on
void unpack(std::span<const h5::PackedRows> columns, std::span<events::Event> events) {
  const auto store = [&]<class T>(const std::vector<T>& values, const auto& set) {
    for (std::size_t i = 0; i < values.size(); ++i) set(events[i], values[i]);
  };
  store(columns[0].unpacked<std::int64_t>(), [](events::Event& event, std::int64_t t) { event.t = camera_time(t); });
  store(columns[1].unpacked<std::uint16_t>(),
        [](events::Event& event, std::uint16_t x) { event.x = static_cast<std::int16_t>(x); });
  store(columns[2].unpacked<std::uint16_t>(),
        [](events::Event& event, std::uint16_t y) { event.y = static_cast<std::int16_t>(y); });
  store(columns[3].unpacked<std::uint8_t>(), [](events::Event& event, std::uint8_t on) { event.on = on; });
}

/// Checks the target of a link of the dataset before HDF5 follows the link.
void check_linked_file(hid_t parent, const std::string& name, const fs::path& dataset) {
  const std::string linked = h5::linked_file(parent, name);
  if (!linked.empty()) h5::check_readable(dataset.parent_path() / linked);
}

/// The shell command that makes the dataset, or the output of `command`, again.
std::string command_for(const fs::path& dataset, const std::string& command) {
  const fs::path folder = dataset.has_parent_path() ? dataset.parent_path() : fs::path(".");
  if (dataset.filename() == "dataset.h5") return "'tactile " + command + " " + shell_word(folder.string()) + "'";
  if (command == "windows") return "'tactile windows DATA --out " + shell_word(dataset.string()) + "'";
  return "'tactile " + command + " " + shell_word(dataset.string()) + "'";
}

/// For a file with damaged values: without removing it, the command would keep it.
std::string remove_and_make(const fs::path& dataset, const std::string& part, const std::string& command) {
  return "Remove " + dataset_layout::file_beside(dataset, part).string() + ", and " + command_for(dataset, command) +
         " makes it again";
}

/// Calls `read`. If that finds damage, the error ends with the remedy.
template <class Read>
auto with_remedy(const std::string& remedy, const Read& read) {
  try {
    return read();
  } catch (const h5::Damaged& e) {
    throw Error(std::string(e.what()) + ". " + remedy);
  }
}

/// The table of a history. It must belong to this dataset and have one heatmap for each sample.
h5::Id open_heatmaps(hid_t group, const std::string& name, const fs::path& dataset, const std::string& manifest_hash,
                     std::size_t samples, const std::string& where) {
  check_linked_file(group, name, dataset);
  h5::Id table = h5::open_table(group, name, where);
  const std::vector<hsize_t> shape = h5::shape_of(table, where);
  if (shape.size() != 3 || shape[0] != samples || shape[1] < 1 || shape[2] < 1 || shape[1] > largest_side ||
      shape[2] > largest_side) {
    throw_inconsistent(where, "the history's shape is not [samples, height, width]");
  }
  if (h5::read_text_attribute(table, "manifest_sha256", where) != manifest_hash) {
    throw Error(where + ": belongs to another dataset; remove the file and run 'tactile heatmaps'");
  }
  return table;
}

}  // namespace

struct Dataset::State {
  fs::path file;
  h5::Id id;
  h5::Id events;  ///< /events as it was checked: a file that replaces its file meanwhile is not read
  events::SensorSize sensor;
  bool simulated = false;
  std::vector<DatasetRun> runs;
  std::vector<DatasetInterval> intervals;
  std::vector<Sample> samples;
  nlohmann::json manifest;
  SamplingOptions sampling;
  std::string manifest_hash;

  ~State() {
    const h5::Session session;
    events = {};
    id = {};
  }

  void read();
  void read_runs(const std::string& where);
  h5::Id checked_events(const std::string& where) const;
  StoredHeatmaps describe(hid_t group, const std::string& name) const;
};

StoredHeatmaps Dataset::State::describe(hid_t group, const std::string& name) const {
  const std::string where = file.string() + ": /heatmaps/" + name;
  const h5::Id table = open_heatmaps(group, name, file, manifest_hash, samples.size(), where);
  h5::check_stored_size(table, where);
  const std::vector<hsize_t> shape = h5::shape_of(table, where);
  return {.name = name,
          .settings = parsed(h5::read_text_attribute(table, "settings", where), where),
          .width = static_cast<int>(shape[2]),
          .height = static_cast<int>(shape[1])};
}

void Dataset::State::read() {
  const std::string where = file.string();
  if (!h5::has_attribute(id, "manifest_sha256")) throw_inconsistent(where, "is not a dataset");
  if (const auto found = h5::read_number(id, "format", where); found != dataset_layout::format) {
    throw Error(where + ": of format " + std::to_string(found) + "; expected " + std::to_string(dataset_layout::format) +
                ", run 'tactile windows' again");
  }
  manifest_hash = h5::read_text_attribute(id, "manifest_sha256", where);
  const auto side = [&](const char* name) {
    return static_cast<int>(std::clamp<std::int64_t>(h5::read_number(id, name, where), 0, 32767));
  };
  sensor = {side("sensor_width"), side("sensor_height")};
  if (sensor.width <= 0 || sensor.height <= 0) throw_inconsistent(where, "the sensor has no area");
  simulated = h5::read_number(id, "simulated", where) != 0;
  read_runs(where);
  const nlohmann::json settings = parsed(h5::read_text_attribute(id, "settings", where), where);
  manifest = dataset_layout::manifest_of(settings, sensor, simulated, runs);
  if (hash_of(manifest) != manifest_hash) throw_inconsistent(where, "its manifest hash is not that of its contents");
  read_all_fields(member<nlohmann::json>(manifest, "sampling", where), sampling, where + ": sampling");

  const auto interval_run = h5::read_table<std::uint32_t>(id, "intervals/run", where);
  const auto interval_class = h5::read_table<std::uint8_t>(id, "intervals/class", where);
  const auto start = h5::read_table<std::int64_t>(id, "intervals/start_us", where);
  const auto end = h5::read_table<std::int64_t>(id, "intervals/end_us", where);
  for (std::size_t i = 0; i < common_length(where + ": /intervals", interval_run, interval_class, start, end); ++i) {
    if (interval_run[i] >= runs.size()) throw_inconsistent(where, "an interval belongs to no run");
    intervals.push_back({interval_run[i], {touch_of(interval_class[i], where), camera_time(start[i]), camera_time(end[i])}});
  }
  const auto sample_run = h5::read_table<std::uint32_t>(id, "samples/run", where);
  const auto t = h5::read_table<std::int64_t>(id, "samples/t_us", where);
  const auto label = h5::read_table<std::uint8_t>(id, "samples/label", where);
  for (std::size_t i = 0; i < common_length(where + ": /samples", sample_run, t, label); ++i) {
    samples.push_back({sample_run[i], camera_time(t[i]), touch_of(label[i], where)});
    const bool in_order = i == 0 || samples[i - 1].run_index < samples[i].run_index ||
                          (samples[i - 1].run_index == samples[i].run_index && samples[i - 1].t < samples[i].t);
    if (sample_run[i] >= runs.size() || !in_order) throw_inconsistent(where, "the samples are not sorted by run and time");
  }
  events = checked_events(where);
}

void Dataset::State::read_runs(const std::string& where) {
  const auto object = h5::read_texts(id, "runs/object", where), run = h5::read_texts(id, "runs/run", where);
  const auto folder = h5::read_texts(id, "runs/folder", where);
  const auto first = h5::read_table<std::uint64_t>(id, "runs/first_event", where);
  const auto counts = h5::read_table<std::uint64_t>(id, "runs/events", where);
  const auto events_sha256 = h5::read_texts(id, "runs/events_sha256", where);
  const auto labels_sha256 = h5::read_texts(id, "runs/labels_sha256", where);
  std::uint64_t next = 0;
  for (std::size_t i = 0; i < common_length(where + ": /runs", object, run, folder, first, counts, events_sha256, labels_sha256);
       ++i) {
    runs.push_back({object[i], run[i], folder[i], first[i], counts[i], events_sha256[i], labels_sha256[i], std::nullopt});
    if (first[i] != next || __builtin_add_overflow(next, counts[i], &next))
      throw_inconsistent(where, "the events of the runs are not contiguous");
  }
  if (const h5::Id group = h5::open_group(id, "runs", where); !h5::has_member(group, "event_digest"))
    return;  // an earlier version
  const auto begin = h5::read_table<std::int64_t>(id, "runs/first_us", where);
  const auto end = h5::read_table<std::int64_t>(id, "runs/last_us", where);
  const auto digest = h5::read_texts(id, "runs/event_digest", where);
  for (std::size_t i = 0; i < common_length(where + ": /runs", runs, begin, end, digest); ++i)
    runs[i].recording = {camera_time(begin[i]), camera_time(end[i]), digest[i]};
}

h5::Id Dataset::State::checked_events(const std::string& where) const {
  check_linked_file(id, "events", file);
  h5::Id group(H5Gopen2(id, "events", H5P_DEFAULT), H5Gclose);
  if (group < 0) h5::fail(where, "its file of events cannot be opened");
  if (h5::read_text_attribute(group, "manifest_sha256", where + ": /events") != manifest_hash) {
    throw Error(where + ": its file of events belongs to another dataset; run 'tactile windows' again");
  }
  const std::uint64_t expected = runs.empty() ? 0 : runs.back().first_event + runs.back().events;
  for (const char* name : {"t_us", "x", "y", "on"}) {
    const std::string column_where = where + ": /events/" + name;
    const h5::Id column = h5::open_table(group, name, column_where);
    if (h5::shape_of(column, column_where) != std::vector<hsize_t>{expected})
      throw_inconsistent(column_where, "has another length than the runs' events");
    h5::check_stored_size(column, column_where);
  }
  return group;
}

Dataset::Dataset(fs::path file) : state_(std::make_unique<State>()) {
  if (!fs::exists(file)) throw Error(file.string() + ": no such dataset; 'tactile windows' makes one");
  const h5::Session session;
  state_->file = std::move(file);
  with_remedy(command_for(state_->file, "windows") + " makes it again", [&] {
    state_->id = h5::open_file(state_->file, false);
    state_->read();
  });
}
Dataset::~Dataset() = default;
Dataset::Dataset(Dataset&&) noexcept = default;
Dataset& Dataset::operator=(Dataset&&) noexcept = default;

const fs::path& Dataset::file() const { return state_->file; }
events::SensorSize Dataset::sensor() const { return state_->sensor; }
bool Dataset::simulated() const { return state_->simulated; }
std::span<const DatasetRun> Dataset::runs() const { return state_->runs; }
std::span<const DatasetInterval> Dataset::intervals() const { return state_->intervals; }
std::span<const Sample> Dataset::samples() const { return state_->samples; }
const nlohmann::json& Dataset::settings() const { return state_->manifest; }
const SamplingOptions& Dataset::sampling() const { return state_->sampling; }
const std::string& Dataset::manifest_hash() const { return state_->manifest_hash; }

fs::path Dataset::run_folder(std::uint32_t run_index) const {
  return state_->file.parent_path() / state_->runs.at(run_index).folder;  // an absolute folder replaces the parent
}

std::vector<events::Event> Dataset::events(std::uint32_t run_index) const {
  return events(run_index, 0, state_->runs.at(run_index).events);
}

std::vector<events::Event> Dataset::events(std::uint32_t run_index, std::uint64_t first, std::uint64_t count) const {
  const DatasetRun& run = state_->runs.at(run_index);
  if (first > run.events || count > run.events - first) {
    throw Error(state_->file.string() + ": " + run.object + "/" + run.run + " has " + std::to_string(run.events) +
                " events; expected at least " + std::to_string(count) + " from " + std::to_string(first) + " on");
  }
  const std::string where = state_->file.string() + ": /events";
  std::vector<h5::PackedRows> columns;
  std::vector<events::Event> events(count);
  with_remedy(remove_and_make(state_->file, "events", "windows"), [&] {
    {
      const h5::Session session;
      const auto read = [&]<class T>(const char* name, T) {
        columns.push_back(h5::PackedRows::of<T>(h5::open_table(state_->events, name, where), run.first_event + first, count,
                                                where + "/" + name));
      };
      read("t_us", std::int64_t{});
      read("x", std::uint16_t{});
      read("y", std::uint16_t{});
      read("on", std::uint8_t{});
    }
    unpack(columns, events);
  });
  const events::SensorSize sensor = state_->sensor;
  const auto is_outside = [sensor](const events::Event& e) {
    return e.x < 0 || e.x >= sensor.width || e.y < 0 || e.y >= sensor.height;  // also if it is above 32767 in the file
  };
  if (std::any_of(events.begin(), events.end(), is_outside)) throw_inconsistent(where, "an event lies outside the sensor");
  return events;
}

std::vector<StoredHeatmaps> Dataset::heatmaps() const {
  const h5::Session session;
  const std::string where = state_->file.string() + ": /heatmaps";
  const h5::Id group(H5Gopen2(state_->id, "heatmaps", H5P_DEFAULT), H5Gclose);
  if (group < 0) h5::fail(where, "cannot be opened");
  std::vector<StoredHeatmaps> stored;
  for (const std::string& name : h5::members_of(group)) stored.push_back(state_->describe(group, name));
  return stored;
}

std::optional<StoredHeatmaps> Dataset::find_heatmaps(const std::string& name) const {
  const h5::Session session;
  const h5::Id group(H5Gopen2(state_->id, "heatmaps", H5P_DEFAULT), H5Gclose);
  if (group < 0 || !h5::has_member(group, name)) return std::nullopt;
  try {
    return state_->describe(group, name);
  } catch (const Error&) {
    return std::nullopt;
  }
}

std::vector<std::string> Dataset::heatmap_names() const {
  const h5::Session session;
  const h5::Id group(H5Gopen2(state_->id, "heatmaps", H5P_DEFAULT), H5Gclose);
  return group < 0 ? std::vector<std::string>{} : h5::members_of(group);
}

std::string Dataset::what_is_wrong_with(const std::string& name) const {
  constexpr std::size_t at_once = 512;  // heatmaps
  try {
    const std::string where = state_->file.string() + ": /heatmaps/" + name;
    std::string written;
    {
      const h5::Session session;
      const h5::Id group(H5Gopen2(state_->id, "heatmaps", H5P_DEFAULT), H5Gclose);
      state_->describe(group, name);
      const h5::Id table = open_heatmaps(group, name, state_->file, state_->manifest_hash, state_->samples.size(), where);
      written = h5::read_text_attribute(table, "sha256", where);
    }
    Sha256 digest;
    for (std::size_t first = 0; first < state_->samples.size(); first += at_once) {
      std::vector<std::uint32_t> indexes(std::min(at_once, state_->samples.size() - first));
      std::iota(indexes.begin(), indexes.end(), static_cast<std::uint32_t>(first));
      digest.add(std::as_bytes(std::span<const std::uint8_t>(read_heatmaps(name, indexes))));
    }
    return digest.hex() == written ? "" : where + ": its values differ from those that were written";
  } catch (const Error& e) {
    return e.what();
  }
}

std::vector<std::uint8_t> Dataset::read_heatmaps(const std::string& name, std::span<const std::uint32_t> sample_indexes) const {
  const h5::Session session;
  const std::string where = state_->file.string() + ": /heatmaps/" + name;
  const h5::Id group(H5Gopen2(state_->id, "heatmaps", H5P_DEFAULT), H5Gclose);
  if (group < 0 || !h5::has_member(group, name)) throw Error(where + ": no such history; 'tactile heatmaps' renders it");
  return with_remedy(remove_and_make(state_->file, name, "heatmaps"), [&] {
    const h5::Id table = open_heatmaps(group, name, state_->file, state_->manifest_hash, state_->samples.size(), where);
    h5::check_stored_size(table, where);
    const std::vector<hsize_t> shape = h5::shape_of(table, where);
    const std::size_t size = shape[1] * shape[2];
    std::vector<std::uint8_t> heatmaps(sample_indexes.size() * size);
    for (std::size_t i = 0; i < sample_indexes.size();) {
      std::size_t end = i + 1;
      while (end < sample_indexes.size() && sample_indexes[end] == sample_indexes[end - 1] + 1) ++end;
      h5::read_rows(table, H5T_NATIVE_UINT8, &heatmaps[i * size], sample_indexes[i], end - i, where);
      i = end;
    }
    return heatmaps;
  });
}

void check_unchanged(const Dataset& dataset, std::uint32_t run_index) {
  const DatasetRun& run = dataset.runs()[run_index];
  const RunFolder folder{dataset.run_folder(run_index), run.object, run.run};
  for (const fs::path& file : {folder.events(), folder.labels()}) {
    if (!fs::exists(file)) {
      throw Error(run.object + "/" + run.run + ": " + file.string() + " is missing; " + dataset.file().string() +
                  " was made from it. 'tactile windows DATA --out " + shell_word(dataset.file().string()) +
                  "' finds runs that have moved");
    }
    const bool same = file == folder.events() ? sha256_of_file(file) == run.events_sha256 : has_labels(run, folder);
    if (!same) {
      throw Error(run.object + "/" + run.run + ": " + file.string() + " has changed since " + dataset.file().string() +
                  " was made; run 'tactile windows' again");
    }
  }
}

bool has_labels(const DatasetRun& run, const RunFolder& folder) {
  return labels::touches_sha256(labels::read_labels(folder.labels())) == run.labels_sha256 ||
         sha256_of_file(folder.labels()) == run.labels_sha256;  // datasets of version 0.1
}

std::string name_of(const DatasetRun& run) { return run.object + "/" + run.run; }

std::vector<std::string> names_of(const Dataset& dataset, std::span<const std::uint32_t> runs) {
  std::vector<std::string> names;
  for (const std::uint32_t run : runs) names.push_back(name_of(dataset.runs()[run]));
  return names;
}

}  // namespace tactile::windows
