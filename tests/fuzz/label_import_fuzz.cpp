#include <array>
#include <tuple>

#include "bytes_as_file.hpp"
#include "checked_labels.hpp"
#include "tactile/core/error.hpp"
#include "tactile/labels/exchange/import_edits.hpp"
#include "tactile/labels/exchange/label_csv.hpp"
#include "tactile/labels/exchange/label_studio.hpp"
#include "tactile/labels/human_edits.hpp"

namespace {

using namespace tactile;

/// Labels before the import: a press and a slip in three seconds.
labels::Labels old_labels() {
  labels::Labels labels;
  for (const auto& [id, touch, start_us] :
       {std::tuple("press-1", Touch::press, 929'637), std::tuple("slip-1", Touch::slip, 1'484'400)}) {
    labels::LabelledInterval interval;
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

void check_edited(const labels::Labels& labels) {
  test::check(labels);
  for (const labels::LabelledInterval& interval : labels.intervals)
    test::abort_unless(interval.end.at >= interval.start.at && !interval.id.empty());
}

void edit(const labels::ImportedLabels& imported) {
  const labels::Labels old = old_labels();
  labels::EditCounts counts;
  const labels::Labels edited = labels::with_edits(old, imported, imported.times.value_or(labels::FileTimes{}), camera_time(0),
                                                   camera_time(3'000'000), counts);
  check_edited(edited);
  check_edited(labels::keep_human_edits(old, edited));
}

}  // namespace

/// For any input, read as the file of each tool: edited labels are in order and do not overlap, or there is an Error.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const test::BytesAsFile file(data, size);
  const std::array<std::vector<labels::ImportedLabels> (*)(const std::filesystem::path&), 2> readers{labels::read_label_studio,
                                                                                                     labels::read_label_csv};
  for (const auto read : readers) {
    try {
      for (const labels::ImportedLabels& imported : read(file.path())) {
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
