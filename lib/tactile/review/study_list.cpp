#include "tactile/review/study_list.hpp"

#include <fmt/core.h>

#include <array>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "tactile/core/error_text.hpp"
#include "tactile/core/folders_in.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/model/bundle/bundle_evaluations.hpp"
#include "tactile/model/bundle/bundle_names.hpp"
#include "tactile/results/evaluation.hpp"
#include "tactile/results/experiment_file.hpp"
#include "tactile/results/stress.hpp"
#include "tactile/results/study.hpp"
#include "tactile/results/trade.hpp"
#include "tactile/review/model_list.hpp"

namespace tactile::review {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double percent = 100;

void add_figure(json& list, const std::string& label, const results::Figure& figure, const char* unit, double factor = 1) {
  const results::Figure shown = results::scaled(figure, factor);
  json entry = figure_json(shown.value, shown.low, shown.high);
  entry["label"] = label;
  entry["unit"] = unit;
  list.push_back(std::move(entry));
}

void add_quantile(json& list, const std::string& label, const results::CensoredQuantile& quantile) {
  add_figure(list, label + (quantile.is_lower_bound ? ", at least" : ""), quantile.ms, "ms");
}

/// When the last step ended; null where no step is named.
json when_of(const results::JsonView& steps) {
  std::string last;
  for (const results::JsonView& step : steps.items()) last = std::max(last, step["finished_at"].text());
  return last.empty() ? json() : json(last);
}

void read_study(json& entry, const results::JsonView& document) {
  const auto study = results::experiment_in<results::Study>(document);
  entry["claims"] = json::array();
  for (const results::Claim& claim : study.claims) {
    entry["claims"].push_back({{"id", claim.id},
                               {"claim", claim.paper},
                               {"outcome", results::name_of(claim.outcome)},
                               {"in_words", words_of(claim)},
                               {"unit", claim.unit},
                               {"measured", figure_json(claim.measured.value, claim.measured.low, claim.measured.high)}});
  }
  for (const results::StudiedSetting& setting : study.results) {
    add_figure(entry["figures"], setting.text + ": accuracy", setting.accuracy.mean, "%", percent);
    if (setting.whole_runs.runs.empty()) continue;
    const results::OperatingPoint& point = setting.whole_runs.decided;
    add_figure(entry["figures"], setting.text + ": false alarms", point.alarms_per_min, "1/min");
    add_quantile(entry["figures"], setting.text + ": median delay", point.median_ms);
  }
}

void read_trade(json& entry, const results::JsonView& document) {
  const auto trade = results::experiment_in<results::Trade>(document);
  for (const results::TradedSetting& setting : trade.points) {
    const results::TradeResult& figures = setting.reported;
    add_figure(entry["figures"], setting.text + ": accuracy", figures.accuracy, "%", percent);
    add_figure(entry["figures"], setting.text + ": time of a tick, p99", figures.us_p99, "us");
  }
  if (!trade.recommendation.sentence.empty()) entry["remarks"].push_back(trade.recommendation.sentence);
}

void read_stress(json& entry, const results::JsonView& stress) {
  for (const auto& model : results::experiment_in<results::Stress>(stress).models) {
    for (const results::StressCurve& curve : model.curves) {
      const std::string label = model.name + ", " + curve.name;
      if (curve.holds) add_figure(entry["figures"], label + ": holds up to", curve.holds->severity, "");
      if (curve.holds && curve.holds->is_beyond) entry["figures"].back()["is_beyond"] = true;
      if (curve.holds) entry["figures"].back()["unit"] = curve.unit;
    }
  }
}

void read_evaluation(json& entry, const results::JsonView& document) {
  const auto evaluation = document.get<results::Evaluation>();
  const results::DetectorScore& score = evaluation.network;
  add_figure(entry["figures"], "Accuracy", evaluation.accuracy.mean, "%", percent);
  for (const auto& [touch, delays] : {std::pair("press", &score.press.all), std::pair("slip", &score.slip.all)}) {
    add_quantile(entry["figures"], fmt::format("Detection delay of {}, median", touch), delays->median_of_all_ms);
    add_figure(entry["figures"], fmt::format("Missed, {}", touch), delays->missed, "%", percent);
  }
  add_figure(entry["figures"], "False alarms", evaluation.whole_runs.decided.alarms_per_min, "1/min");
}

struct Kind {
  const char* name;
  void (*read)(json& entry, const results::JsonView& document);
};

constexpr Kind evaluation{"eval", read_evaluation};
constexpr std::array<Kind, 4> kinds{{{"study", read_study}, {"trade", read_trade}, {"stress", read_stress}, evaluation}};

json study_json(const fs::path& file, const Kind& kind) {
  const std::string name = fs::absolute(file).lexically_normal().parent_path().filename().string();
  json entry = {{"name", name.empty() ? kind.name : name},
                {"kind", kind.name},
                {"title", ""},
                {"when", nullptr},
                {"figures", json::array()},
                {"claims", json::array()},
                {"remarks", json::array()},
                {"error", nullptr}};
  try {
    const json document = read_json(file);
    const results::JsonView view(document, file.string());
    entry["title"] = view["title"].text();
    entry["simulated"] = view["simulated"].truth();
    entry["when"] = when_of(view["steps"]);
    kind.read(entry, view);
  } catch (const std::exception& e) {
    entry["error"] = sentence_of(e, file.string());
  }
  return entry;
}

}  // namespace

json studies_json(const fs::path& folder, const fs::path& models) {
  std::vector<fs::path> places{folder};
  const std::vector<fs::path> below = folders_in(folder);
  places.insert(places.end(), below.begin(), below.end());
  json list = json::array();
  for (const fs::path& place : places) {
    for (const Kind& kind : kinds) {
      const fs::path file = place / (std::string(kind.name) + ".json");
      if (is_file(file)) list.push_back(study_json(file, kind));
    }
  }
  for (const std::string& name : model::bundle_names(models)) {
    if (const auto file = model::newest_evaluation({models / name})) list.push_back(study_json(*file, evaluation));
  }
  return list;
}

}  // namespace tactile::review
