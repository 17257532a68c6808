#include "tactile/results/found.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace tactile::results {
namespace {

std::string percent_of(const Figure& figure, std::string_view unit = " %") { return text_of(scaled(figure, 100), unit, ".1f"); }

std::string within(const CensoredQuantile& quantile) {
  return (quantile.is_lower_bound ? "no less than " : "") + text_of(quantile.ms, " ms", ".0f");
}

/// What a robot would meet.
std::string whole_runs_sentence(const std::string& who, const WholeRuns& whole) {
  const OperatingPoint& point = whole.decided;
  std::string text = fmt::format("{}, on {} whole runs of all kinds: {} false alarms a minute", who, whole.runs.size(),
                                 text_of(point.alarms_per_min, ""));
  if (point.touches > 0)
    text += fmt::format("; half of the touches are detected within {}, 90 % within {}, and {} of {} are missed",
                        within(point.median_ms), within(point.p90_ms), point.misses + point.early, point.touches);
  if (point.lifts > 0)
    text += fmt::format("; slip is reported in {} of {} lifts without slip", point.lifts_with_slip, point.lifts);
  return text + ".";
}

std::string accuracy_sentence(const std::string& who, const Accuracy& accuracy) {
  return fmt::format("{} predicts {} of the balanced samples correctly.", who, percent_of(accuracy.mean));
}

std::string unseen_sentence(const std::string& who, const UnseenComparison& unseen) {
  const Figure& change = unseen.mean.difference;
  return fmt::format("On {} object{} that it has never seen the accuracy of {} changes by {}.", unseen.objects.size(),
                     unseen.objects.size() == 1 ? "" : "s", who, percent_of(change, " points"));
}

void add_note(std::vector<std::string>& sentences, std::initializer_list<Figure> figures) {
  std::string note = note_on_intervals(figures);
  if (!note.empty()) sentences.push_back(std::move(note));
}

}  // namespace

std::vector<std::string> found_in(const Evaluation& evaluation, const UnseenComparison& unseen) {
  const std::string& name = evaluation.models.front().name;
  std::vector<std::string> sentences{whole_runs_sentence(name, evaluation.whole_runs),
                                     accuracy_sentence(name, evaluation.accuracy)};
  if (!unseen.objects.empty()) sentences.push_back(unseen_sentence(name, unseen));
  add_note(sentences, {evaluation.accuracy.mean, evaluation.whole_runs.decided.alarms_per_min,
                       measured(evaluation.whole_runs.decided.median_ms)});
  return sentences;
}

std::vector<std::string> found_in(const Study& study) {
  std::vector<std::string> sentences;
  for (const StudiedSetting& setting : study.results) {
    if (setting.whole_runs.runs.empty()) continue;
    sentences.push_back(whole_runs_sentence(setting.text, setting.whole_runs));
    if (!setting.is_unseen) sentences.push_back(accuracy_sentence(setting.text, setting.accuracy));
  }
  for (const StudiedUnseen& unseen : study.unseen) {
    if (!unseen.accuracy.objects.empty()) sentences.push_back(unseen_sentence(unseen.text, unseen.accuracy));
  }
  if (!study.results.empty()) add_note(sentences, {study.results.front().accuracy.mean});
  return sentences;
}

}  // namespace tactile::results
