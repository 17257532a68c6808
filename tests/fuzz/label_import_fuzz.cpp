#include <array>
#include <cstdlib>
#include <tuple>

#include "bytes_as_file.hpp"
#include "tactile/core/error.hpp"
#include "tactile/labels/exchange/audacity.hpp"
#include "tactile/labels/exchange/elan.hpp"
#include "tactile/labels/exchange/import_edits.hpp"
#include "tactile/labels/exchange/label_csv.hpp"
#include "tactile/labels/exchange/label_studio.hpp"
#include "tactile/labels/human_edits.hpp"

namespace {

using namespace tactile;

/// A press and a slip of a recording of three seconds.
Labels labels_there() {
  Labels labels;
  for (const auto& [id, touch, start_us] :
       {std::tuple("press-1", Touch::press, 929'637), std::tuple("slip-1", Touch::slip, 1'484'400)}) {
    LabelledInterval interval;
    interval.id = id;
    interval.touch = touch;
    interval.start = {camera_time(start_us), camera_time(start_us - 700), camera_time(start_us + 900)};
    interval.end = {camera_time(start_us + 200'000), camera_time(start_us + 190'000), camera_time(start_us + 220'000)};
    interval.source = "events";
    labels.intervals.push_back(interval);
  }
  labels.flags = {{.interval_index = 1, .reason = "weak", .confirmed = false}};
  return labels;
}

void check(const Labels& labels) {
  for (std::size_t i = 0; i < labels.intervals.size(); ++i) {
    if (labels.intervals[i].end.at < labels.intervals[i].start.at || labels.intervals[i].id.empty()) std::abort();
    if (i > 0 && labels.intervals[i].start.at < labels.intervals[i - 1].end.at) std::abort();
  }
  for (const LabelFlag& flag : labels.flags) {
    if (flag.interval_index && *flag.interval_index >= labels.intervals.size()) std::abort();
  }
}

void edit(const ImportedLabels& imported) {
  const Labels old = labels_there();
  EditCounts counts;
  const Labels edited =
      with_edits(old, imported, imported.times.value_or(FileTimes{}), camera_time(0), camera_time(3'000'000), counts);
  check(edited);
  check(keep_human_edits(old, edited));
}

}  // namespace

/// Whatever the bytes, and whichever tool they pass for: labels that come of them are in order, do not overlap, and can be kept.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const test::BytesAsFile file(data, size);
  const std::array<std::vector<ImportedLabels> (*)(const std::filesystem::path&), 4> readers{
      [](const std::filesystem::path& path) { return std::vector{read_audacity(path)}; },
      [](const std::filesystem::path& path) { return std::vector{read_elan(path)}; }, read_label_studio, read_label_csv};
  for (const auto read : readers) {
    try {
      for (const ImportedLabels& imported : read(file.path())) {
        try {
          edit(imported);
        } catch (const Error&) {
        }
      }
    } catch (const Error&) {
    }
  }
  return 0;
}
