#include "tactile/study/study_json.hpp"

#include <fmt/core.h>

#include <cmath>
#include <limits>
#include <thread>

#include "tactile/core/json.hpp"
#include "tactile/core/machine.hpp"
#include "tactile/core/version.hpp"
#include "tactile/model/training/torch_version.hpp"

namespace tactile {
namespace {

std::optional<double> number_in(const nlohmann::json& json, std::string_view key, const std::string& where) {
  const auto value = member<nlohmann::json>(json, key, where);
  if (value.is_null()) return std::nullopt;
  return member<double>(json, key, where);
}

std::string cell(double number) { return std::isfinite(number) ? nlohmann::json(number).dump() : ""; }

std::string cells(const Figure& figure) {
  return fmt::format("{},{},{},{}", cell(figure.value), cell(figure.low.value_or(NAN)), cell(figure.high.value_or(NAN)),
                     figure.n);
}

nlohmann::json compared(const Figure& seen, const Figure& held_out, const Figure& difference) {
  return {{"seen", seen}, {"held_out", held_out}, {"difference", difference}};
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

Figure figure_in(const nlohmann::json& json, const std::string& where) {
  return {number_in(json, "value", where).value_or(std::numeric_limits<double>::quiet_NaN()), number_in(json, "low", where),
          number_in(json, "high", where), member<std::size_t>(json, "n", where)};
}

std::map<std::string, ObjectDelays> delays_in(const nlohmann::json& evaluation, const std::string& touch,
                                              const std::string& where) {
  const auto table = member<nlohmann::json>(member<nlohmann::json>(evaluation, "delay_ms", where), touch, where);
  std::map<std::string, ObjectDelays> delays;
  const auto objects = member<nlohmann::json>(table, "objects", where);
  for (const auto& [object, delay] : objects.items()) {
    delays[object] = {figure_in(member<nlohmann::json>(delay, "mean", where), where),
                      member<std::uint64_t>(delay, "intervals", where), member<std::uint64_t>(delay, "misses", where),
                      member<std::uint64_t>(delay, "early", where)};
  }
  return delays;
}

std::vector<RunDetections> detections_in(const nlohmann::json& evaluation, const std::string& where) {
  std::vector<RunDetections> runs;
  for (const nlohmann::json& run : member<nlohmann::json>(evaluation, "runs", where)) {
    runs.push_back({member<std::string>(run, "object", where), {}});
    for (const nlohmann::json& interval : member<nlohmann::json>(run, "intervals", where))
      runs.back().detections.push_back(detection_in(interval, where));
  }
  return runs;
}

std::map<std::string, bool> told_at_once(const std::map<std::string, ObjectDelays>& delays, double tick_ms) {
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

void to_json(nlohmann::json& json, const SeenAndHeldOut& comparison) {
  json = {{"runs", comparison.runs},
          {"mean", compared(comparison.seen.mean, comparison.held_out.mean, comparison.difference.mean)},
          {"objects", nlohmann::json::object()}};
  for (const auto& [object, seen] : comparison.seen.objects)
    json["objects"][object] = compared(seen, comparison.held_out.objects.at(object), comparison.difference.objects.at(object));
}

std::string unseen_csv(const std::vector<UnseenRow>& rows) {
  std::string text = "split,runs,object,of,value,low,high,n\n";
  for (const UnseenRow& row : rows) {
    for (const auto& [of, accuracy] : {std::pair("seen", &row.comparison->seen), std::pair("held_out", &row.comparison->held_out),
                                       std::pair("difference", &row.comparison->difference)}) {
      text += fmt::format("{},{},all,{},{}\n", row.split, row.runs, of, cells(accuracy->mean));
      for (const auto& [object, figure] : accuracy->objects)
        text += fmt::format("{},{},{},{},{}\n", row.split, row.runs, object, of, cells(figure));
    }
  }
  return text;
}

std::string claims_csv(const std::vector<Claim>& reported, const std::vector<Claim>& all_test) {
  std::string text = "id,runs,value,low,high,n,unit,asked,limit,kept,of,verdict\n";
  const auto add = [&](const Claim& claim, const char* runs) {
    const auto count = [](const std::optional<std::size_t>& objects) {
      return objects ? std::to_string(*objects) : std::string();
    };
    text += fmt::format("{},{},{},{},{},{},{},{},{}\n", claim.id, runs, cells(claim.measured), claim.unit,
                        claim.asked == Asked::below ? "below" : "above", claim.limit, count(claim.kept), count(claim.of),
                        name_of(claim.verdict));
  };
  for (std::size_t i = 0; i < reported.size(); ++i) {
    add(reported[i], "reported");
    if (i < all_test.size()) add(all_test[i], "all_test");
  }
  return text;
}

}  // namespace tactile
