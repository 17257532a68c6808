#include "tactile/windows/dataset.hpp"

#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <mutex>

#include "arrays.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/labels/labels.hpp"
#include "tactile/model/bundle/model_bundle.hpp"
#include "tactile/windows/dataset_split.hpp"
#include "working_alone.hpp"

namespace tactile::python {
namespace {

/// A dataset. Threads of Python that read it at the same time wait for each other.
struct Dataset {
  explicit Dataset(const std::string& file) : dataset(file) {}

  std::mutex mutex;
  windows::Dataset dataset;
};

/// (run, t [us], class) of every sample.
nb::tuple samples_of(const Dataset& file) {
  std::vector<std::uint32_t> runs;
  std::vector<std::int64_t> times;
  std::vector<std::uint8_t> touches;
  for (const windows::Sample& sample : file.dataset.samples()) {
    runs.push_back(sample.run_index);
    times.push_back(sample.t.time_since_epoch().count());
    touches.push_back(static_cast<std::uint8_t>(sample.touch));
  }
  return nb::make_tuple(array_of(std::move(runs)), array_of(std::move(times)), array_of(std::move(touches)));
}

std::vector<std::pair<std::string, std::string>> runs_of(const Dataset& file) {
  std::vector<std::pair<std::string, std::string>> runs;
  for (const windows::DatasetRun& run : file.dataset.runs()) runs.emplace_back(run.object, run.run);
  return runs;
}

/// Indexes of the runs to train on, and to test on.
std::pair<std::vector<std::uint32_t>, std::vector<std::uint32_t>> split_runs(const Dataset& file, const std::string& kind,
                                                                             const std::string& train_run,
                                                                             const std::vector<std::string>& held_out) {
  const windows::Split split =
      windows::split_runs(file.dataset, {.kind = windows::split_named(kind), .train_run = train_run, .held_out = held_out});
  return {split.train_runs, split.test_runs};
}

std::pair<int, int> heatmap_size(Dataset& file, const std::string& name) {
  const WorkingAlone alone(file.mutex);
  if (const auto stored = file.dataset.find_heatmaps(name)) return {stored->height, stored->width};
  std::string names;
  for (const windows::StoredHeatmaps& stored : file.dataset.heatmaps()) names += (names.empty() ? "" : ", ") + stored.name;
  throw Error(file.dataset.file().string() + ": has no heatmaps " + name + "; expected " +
              (names.empty() ? "tactile heatmaps to be run first" : "one of " + names));
}

NumpyArray<std::uint8_t> heatmaps_of(Dataset& file, const std::string& name, const GivenArray<std::uint32_t, 1>& samples) {
  const auto [height, width] = heatmap_size(file, name);
  const std::span<const std::uint32_t> indexes(samples.data(), samples.size());
  for (const std::uint32_t index : indexes) {
    if (index >= file.dataset.samples().size())
      throw Error(file.dataset.file().string() + ": has no sample " + std::to_string(index) + "; expected 0 to " +
                  std::to_string(file.dataset.samples().size() - 1));
  }
  std::vector<std::uint8_t> values;
  {
    const WorkingAlone alone(file.mutex);
    values = file.dataset.read_heatmaps(name, indexes);
  }
  return array_of(std::move(values), {indexes.size(), static_cast<std::size_t>(height), static_cast<std::size_t>(width)});
}

EventBytes events_of_run(Dataset& file, std::uint32_t run) {
  std::vector<events::Event> events;
  {
    const WorkingAlone alone(file.mutex);
    events = file.dataset.events(run);
  }
  return event_bytes_of(std::move(events));
}

/// The text of NAME.json of a network that learned from these runs' heatmaps.
std::string network_description(const Dataset& file, const std::string& heatmaps, const std::vector<std::uint32_t>& runs) {
  const auto stored = file.dataset.find_heatmaps(heatmaps);
  if (!stored) throw Error(file.dataset.file().string() + ": has no heatmaps " + heatmaps + "; expected those that it had");
  model::OwnDescription description;
  description.input_name = "heatmaps";
  description.output_name = "logits";
  description.sensor = file.dataset.sensor();
  description.rendering = stored->settings.get<heatmaps::HeatmapOptions>();
  for (const std::uint32_t run : runs) {
    if (run >= file.dataset.runs().size()) throw Error(file.dataset.file().string() + ": has no run " + std::to_string(run));
    description.learned_from.push_back(model::learned_run_of(file.dataset.runs()[run]));
  }
  return nlohmann::json(description).dump();
}

/// The text of labels.json, once `read_labels` has found it sound.
std::string labels_text(const std::string& file) {
  labels::read_labels(file);
  return read_text(file);
}

}  // namespace

void bind_dataset(nb::module_& module) {
  module.attr("default_held_out") = windows::default_held_out();
  module.def("labels_text", &labels_text, nb::arg("path"));
  nb::class_<Dataset>(module, "DatasetFile")
      .def(nb::init<const std::string&>(), nb::arg("path"), nb::call_guard<OtherThreadsRun>())
      .def_prop_ro("runs", &runs_of)
      .def_prop_ro("simulated", [](const Dataset& file) { return file.dataset.simulated(); })
      .def_prop_ro("manifest_hash", [](const Dataset& file) { return file.dataset.manifest_hash(); })
      .def("samples", &samples_of)
      .def("split_runs", &split_runs, nb::arg("kind"), nb::arg("train_run"), nb::arg("held_out"))
      .def("heatmap_size", &heatmap_size, nb::arg("name"))
      .def("heatmaps", &heatmaps_of, nb::arg("name"), nb::arg("samples"))
      .def("network_description", &network_description, nb::arg("heatmaps"), nb::arg("runs"))
      .def("events", &events_of_run, nb::arg("run"));
}

}  // namespace tactile::python
