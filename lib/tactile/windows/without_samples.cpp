#include "tactile/windows/without_samples.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/text_lines.hpp"

namespace tactile::windows {
namespace fs = std::filesystem;

namespace {

std::vector<std::string> standing_flags(const labels::Labels& labels, std::optional<std::size_t> interval) {
  std::vector<std::string> reasons;
  for (const labels::LabelFlag& flag : labels.flags) {
    if (!flag.confirmed && flag.interval_index == interval) reasons.push_back(flag.reason);
  }
  return reasons;
}

std::string joined_by_and(const std::vector<std::string>& names) {
  if (names.size() < 2) return fmt::format("{}", fmt::join(names, ""));
  return fmt::format("{} and {}", fmt::join(names.begin(), names.end() - 1, ", "), names.back());
}

bool has_samples(const Dataset& dataset, std::uint32_t run) {
  const auto samples = dataset.samples();
  return std::any_of(samples.begin(), samples.end(), [&](const Sample& sample) { return sample.run_index == run; });
}

}  // namespace

NoSamples has_no(const std::string& what) { return {"no " + what, ", which has no " + what, "", false}; }

std::optional<NoSamples> why_no_samples(const labels::Labels& labels, bool include_flagged) {
  if (labels.run_is_flagged() && !include_flagged) {
    return NoSamples{"the whole run is flagged", ", which is flagged",
                     fmt::format("{}", fmt::join(standing_flags(labels, std::nullopt), "; ")), true};
  }
  std::vector<std::string> flagged, missing, reasons;
  for (const Touch touch : {Touch::press, Touch::slip}) {
    std::vector<std::string> of_touch;
    bool has_one = false;
    for (std::size_t i = 0; i < labels.intervals.size(); ++i) {
      if (labels.intervals[i].touch != touch) continue;
      if (include_flagged || !labels.interval_is_flagged(i)) {
        has_one = true;
        break;
      }
      of_touch.push_back(labels.intervals[i].id);
      for (std::string& reason : standing_flags(labels, i)) reasons.push_back(std::move(reason));
    }
    if (has_one) continue;
    if (of_touch.empty()) missing.emplace_back(name_of(touch));
    flagged.insert(flagged.end(), of_touch.begin(), of_touch.end());
  }
  if (flagged.empty() && missing.empty()) return std::nullopt;
  if (flagged.empty()) return has_no(fmt::format("{}", fmt::join(missing, " and no ")));
  std::string words = fmt::format("{} {} flagged", joined_by_and(flagged), flagged.size() == 1 ? "is" : "are");
  std::string clause = ", whose " + words;
  if (!missing.empty()) {
    words += fmt::format(", and no {}", missing.front());
    clause += fmt::format(" and which has no {}", missing.front());
  }
  return NoSamples{words, clause, fmt::format("{}", fmt::join(reasons, "; ")), true};
}

std::optional<NoSamples> why_no_samples(const Dataset& dataset, const RunFolder& run) {
  bool is_in_dataset = false;
  for (std::uint32_t i = 0; i < dataset.runs().size(); ++i) {
    if (dataset.runs()[i].object != run.object || dataset.runs()[i].run != run.run) continue;
    if (has_samples(dataset, i)) return std::nullopt;
    is_in_dataset = true;
  }
  std::error_code unreadable;
  if (!is_in_dataset && !fs::exists(run.events(), unreadable)) return NoSamples{"no such run", ", which is not there", "", false};
  if (!is_in_dataset && !fs::exists(run.labels(), unreadable)) return has_no("labels");
  try {
    const bool include_flagged = member<bool>(dataset.settings(), "include_flagged", dataset.file().string());
    if (auto reason = why_no_samples(labels::read_labels(run.labels()), include_flagged)) return reason;
  } catch (const Error&) {
    if (!is_in_dataset) return NoSamples{"labels cannot be read", ", whose labels cannot be read", "", false, true};
  }
  return has_no(is_in_dataset ? "samples" : "place in the dataset");
}

fs::path data_folder_of(const Dataset& dataset) { return dataset.run_folder(0).parent_path().parent_path(); }

RunFolder run_of(const Dataset& dataset, const std::string& object, const std::string& run) {
  for (std::uint32_t i = 0; i < dataset.runs().size(); ++i) {
    if (dataset.runs()[i].object == object && dataset.runs()[i].run == run) return {dataset.run_folder(i), object, run};
  }
  return {data_folder_of(dataset) / object / run, object, run};
}

std::vector<RunWithoutSamples> runs_without_samples(const Dataset& dataset, std::span<const RunFolder> runs) {
  std::vector<RunWithoutSamples> without;
  for (const RunFolder& run : runs) {
    if (auto reason = why_no_samples(dataset, run)) without.push_back({run.object, run.run, *reason});
  }
  return without;
}

std::vector<RunWithoutSamples> runs_of_objects_left_out(const Dataset& dataset) {
  std::map<std::string, std::set<std::string>> runs;  // of each object, in the dataset or in its folder
  std::set<std::string> in_dataset, with_samples;
  for (const DatasetRun& run : dataset.runs()) {
    runs[run.object].insert(run.run);
    in_dataset.insert(run.object);
  }
  for (const Sample& sample : dataset.samples()) with_samples.insert(dataset.runs()[sample.run_index].object);
  if (const fs::path data = data_folder_of(dataset); fs::is_directory(data)) {
    for (const RunFolder& run : find_runs(data)) runs[run.object].insert(run.run);
  }
  std::vector<RunWithoutSamples> left_out;
  for (const auto& [object, of_object] : runs) {
    if (with_samples.contains(object)) continue;
    std::vector<RunFolder> folders;
    for (const std::string& run : of_object) folders.push_back(run_of(dataset, object, run));
    const std::vector<RunWithoutSamples> without = runs_without_samples(dataset, folders);
    if (in_dataset.contains(object) || std::any_of(without.begin(), without.end(), [](const RunWithoutSamples& run) {
          return run.reason.flagged || run.reason.unreadable;
        }))
      left_out.insert(left_out.end(), without.begin(), without.end());
  }
  return left_out;
}

std::string reasons_of(std::span<const RunWithoutSamples> runs) {
  std::vector<std::pair<std::string, std::vector<std::string>>> groups;  // in the order of their first runs
  for (const RunWithoutSamples& run : runs) {
    auto group = std::find_if(groups.begin(), groups.end(), [&](const auto& one) { return one.first == run.reason.words; });
    if (group == groups.end()) group = groups.insert(group, {run.reason.words, {}});
    group->second.push_back(run.object + "/" + run.run);
  }
  std::vector<std::string> texts;
  for (const auto& [words, names] : groups) texts.push_back(fmt::format("{} in {}", words, fmt::join(names, ", ")));
  return fmt::format("{}", fmt::join(texts, "; "));
}

std::vector<std::string> objects_left_out(std::span<const RunWithoutSamples> runs, const std::set<std::string>& with_samples) {
  std::map<std::string, std::vector<RunWithoutSamples>> by_object;
  for (const RunWithoutSamples& run : runs) {
    if (!with_samples.contains(run.object)) by_object[run.object].push_back(run);
  }
  std::vector<std::string> sentences;
  for (const auto& [object, of_object] : by_object)
    sentences.push_back(fmt::format("{}: left out, none of its runs has samples: {}", object, reasons_of(of_object)));
  return sentences;
}

void refuse_objects_left_out(std::span<const std::string> sentences) {
  if (sentences.empty()) return;
  throw Error(fmt::format("{}; expected a run with samples of every object, as --strict asks for", fmt::join(sentences, "; ")));
}

std::string how_to_lift_flags(const RunFolder& run, const std::string& command) {
  return fmt::format(
      "Look at it with 'tactile view {0}'. If a flagged label is right, confirm it by 'tactile label --confirm {0}' and run "
      "'{1}' "
      "again. '{1} --include-flagged' uses flagged labels as they are.",
      shell_word(run.folder.string()), command);
}

std::string sentence_on(std::span<const RunWithoutSamples> runs, std::size_t of_all, const fs::path& data,
                        const std::string& command) {
  const std::string sentence = fmt::format("{} of {} run{} no samples: {}.", runs.size(), of_all,
                                           of_all == 1        ? " has"
                                           : runs.size() == 1 ? "s has"
                                                              : "s have",
                                           reasons_of(runs));
  const auto flagged = std::find_if(runs.begin(), runs.end(), [](const RunWithoutSamples& run) { return run.reason.flagged; });
  if (flagged == runs.end()) return sentence;
  return sentence + " " + how_to_lift_flags({data / flagged->object / flagged->run, flagged->object, flagged->run}, command);
}

}  // namespace tactile::windows
