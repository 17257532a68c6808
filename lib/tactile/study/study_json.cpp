#include "tactile/study/study_json.hpp"

#include <fmt/core.h>

#include <cmath>
#include <thread>

#include "tactile/core/machine.hpp"
#include "tactile/core/version.hpp"
#include "tactile/model/training/torch_version.hpp"

namespace tactile {
namespace {

std::string cell(double number) { return std::isfinite(number) ? nlohmann::json(number).dump() : ""; }

std::string cells(const Figure& figure) {
  return fmt::format("{},{},{},{}", cell(figure.value), cell(figure.low.value_or(NAN)), cell(figure.high.value_or(NAN)),
                     figure.n);
}

}  // namespace

nlohmann::json software_json() {
  return {{"name", "tactile"}, {"version", version()}, {"revision", revision()}, {"libtorch", torch_version()}};
}

nlohmann::json machine_json(unsigned threads) {
  return {{"cpu", cpu_name()},
          {"system", system_name()},
          {"cores", std::thread::hardware_concurrency()},
          {"memory_bytes", memory_bytes()},
          {"threads", threads}};
}

nlohmann::json steps_json(std::span<const StepRecord> steps) {
  nlohmann::json json = nlohmann::json::array();
  for (const StepRecord& step : steps) {
    json.push_back({{"name", step.name},
                    {"command", step.command.empty() ? nlohmann::json() : nlohmann::json(step.command)},
                    {"seconds", step.seconds},
                    {"finished_at", step.finished_at}});
  }
  return json;
}

std::string from_folder(const std::filesystem::path& path, const std::filesystem::path& folder) {
  // Absolute first: what is not there yet would stay as it is, and be told otherwise once it is there.
  const auto whole = [](const std::filesystem::path& any) {
    return std::filesystem::weakly_canonical(std::filesystem::absolute(any));
  };
  return whole(path).lexically_relative(whole(folder)).generic_string();
}

std::vector<RunDetections> detections_in(const nlohmann::json& evaluation, const std::string& where) {
  std::vector<RunDetections> runs;
  for (const JsonView& run : JsonView(evaluation, where, MissingMember::is_error)["runs"].items())
    runs.push_back({run["object"].text(), run["intervals"].list_of<Detection>()});
  return runs;
}

std::map<std::string, bool> told_at_once(const std::map<std::string, DelaySummary>& delays, double tick_ms) {
  std::map<std::string, bool> at_once;
  for (const auto& [object, delay] : delays) {
    if (delay.intervals > 0) at_once[object] = delay.misses + delay.early == 0 && delay.mean_ms.value <= tick_ms * (1 + 1e-9);
  }
  return at_once;
}

std::string accuracy_csv(const std::vector<AccuracyRow>& rows) {
  std::string text = "th_ms,runs,object,value,low,high,n\n";
  for (const AccuracyRow& row : rows) {
    text += fmt::format("{},{},all,{}\n", row.history_ms, row.runs, cells(row.accuracy->mean));
    for (const auto& [object, figure] : row.accuracy->objects)
      text += fmt::format("{},{},{},{}\n", row.history_ms, row.runs, object, cells(figure));
  }
  return text;
}

std::string unseen_csv(const std::vector<UnseenRow>& rows) {
  std::string text = "split,runs,object,of,value,low,high,n\n";
  for (const UnseenRow& row : rows) {
    for (const auto& [of, figure] : {std::pair("seen", &SeenAndHeldOut::seen), std::pair("held_out", &SeenAndHeldOut::held_out),
                                     std::pair("difference", &SeenAndHeldOut::difference)}) {
      text += fmt::format("{},{},all,{},{}\n", row.split, row.runs, of, cells(row.comparison.mean.*figure));
      for (const auto& [object, of_object] : row.comparison.objects)
        text += fmt::format("{},{},{},{},{}\n", row.split, row.runs, object, of, cells(of_object.*figure));
    }
  }
  return text;
}

std::string claims_csv(const std::vector<Claim>& claims) {
  std::string text = "id,runs,value,low,high,n,unit,asked,limit,kept,of,verdict\n";
  const auto add = [&](const Claim& claim, const char* runs, const ClaimOutcome& outcome) {
    const auto count = [](const std::optional<std::size_t>& objects) {
      return objects ? std::to_string(*objects) : std::string();
    };
    text += fmt::format("{},{},{},{},{},{},{},{},{}\n", claim.id, runs, cells(outcome.measured), claim.unit, name_of(claim.asked),
                        claim.limit, count(outcome.kept), count(outcome.of), name_of(outcome.verdict));
  };
  for (const Claim& claim : claims) {
    add(claim, "reported", claim);
    if (claim.all_test) add(claim, "all_test", *claim.all_test);
  }
  return text;
}

}  // namespace tactile
