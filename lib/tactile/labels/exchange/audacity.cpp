#include "tactile/labels/exchange/audacity.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/text.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::labels {
namespace {

std::string_view next_word(std::string_view& text) {
  const std::size_t begin = std::min(text.find_first_not_of(' '), text.size());
  const std::size_t end = std::min(text.find(' ', begin), text.size());
  const std::string_view word = text.substr(begin, end - begin);
  text.remove_prefix(end);
  return word;
}

/// "# fan/01 from video, zero -1.203344 s, drift 12.5 ppm"; any other label of this kind is a comment.
void read_statement(std::string_view text, ImportedLabels& labels) {
  text.remove_prefix(1);
  const std::string_view run = next_word(text);
  if (next_word(text) != "from") return;
  std::string_view origin_word = next_word(text);
  if (origin_word.ends_with(',')) origin_word.remove_suffix(1);
  const std::optional<TimeOrigin> origin = time_origin_named(origin_word);
  if (!origin) return;
  FileTimes times{.origin = *origin};
  if (next_word(text) == "zero") {
    const std::optional<ReadSeconds> zero = seconds_in(next_word(text));
    next_word(text);
    next_word(text);
    const std::optional<double> drift = number_in(next_word(text));
    if (!zero || !drift || !(std::abs(*drift) < 1e5)) return;
    times.zero_us = zero->us;
    times.drift_ppm = *drift;
  }
  labels.run = std::string(run);
  labels.times = times;
}

}  // namespace

std::string audacity_text(const LabelsToExport& labels) {
  check_ids(labels);
  const ClockRelation clock = labels.times.to_camera(labels.first_event);
  const auto line = [](std::int64_t start_us, std::int64_t end_us, const std::string& text) {
    return fmt::format("{}\t{}\t{}\n", seconds_text(start_us), seconds_text(end_us), text);
  };
  std::string statement = fmt::format("# {} from {}", labels.run, name_of(labels.times.origin));
  if (labels.times.origin == TimeOrigin::video)
    statement += fmt::format(", zero {} s, drift {} ppm", seconds_text(labels.times.zero_us), labels.times.drift_ppm);
  // With camera time, 0 is decades before the labels, so this label would not be seen.
  const std::int64_t begin = labels.times.origin == TimeOrigin::camera ? us_of(labels.first_event) : 0;
  std::string text = line(begin, begin, statement);
  for (const LabelledInterval& interval : labels.labels.intervals) {
    const double half_ms = static_cast<double>(between(interval.start.low, interval.start.high).count()) / 2000.0;
    text += line(
        clock.clock_us_from(interval.start.at), clock.clock_us_from(interval.end.at),
        fmt::format("{} {} 95% ±{:.1f} ms{}", interval.id, name_of(interval.touch), half_ms, interval.confirmed ? " ok" : ""));
  }
  return text;
}

ImportedLabels read_audacity(const std::filesystem::path& file) {
  const std::string text = read_text(file, std::size_t{8} << 20);
  std::string_view rest = text;
  if (rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3);
  ImportedLabels labels{.where = file.string(), .earliest_us = 0};  // no label of a track begins before it
  bool is_empty = true;
  for (std::size_t number = 1; !rest.empty(); ++number) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    std::string_view line = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (line.empty() || line.front() == '\\') continue;
    is_empty = false;
    const std::string where = fmt::format("{}, line {}", file.string(), number);
    const std::size_t first = line.find('\t'), second = first == line.npos ? line.npos : line.find('\t', first + 1);
    if (second == line.npos) {
      throw Error(fmt::format("{}: {} is not a label; expected 'start TAB end TAB text', as Audacity exports labels", where,
                              shown_text(line)));
    }
    const auto seconds = [&](std::string_view value) {
      const std::optional<ReadSeconds> read = seconds_in(value);
      if (!read) throw Error(fmt::format("{}: {} is not a time; expected seconds, such as 1.250000", where, shown_text(value)));
      return *read;
    };
    const ReadSeconds start = seconds(line.substr(0, first)), stop = seconds(line.substr(first + 1, second - first - 1));
    const std::string_view words = line.substr(second + 1);
    if (words.starts_with('#')) {
      if (!labels.run) read_statement(words, labels);
      continue;
    }
    ImportedInterval interval{.start_us = start.us,
                              .end_us = stop.us,
                              .start_rounding_us = start.rounding_us,
                              .end_rounding_us = stop.rounding_us,
                              .where = where};
    read_words(words, where, interval);
    labels.intervals.push_back(std::move(interval));
    check_count(labels.intervals.size(), most_imported_intervals, "labels", file);
  }
  if (is_empty) throw Error(file.string() + ": has no label; expected a label track of Audacity");
  return labels;
}

}  // namespace tactile::labels
