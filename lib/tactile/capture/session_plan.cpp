#include "tactile/capture/session_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/runs_below.hpp"

namespace tactile::capture {
namespace fs = std::filesystem;
namespace {

void check_keys(const nlohmann::json& json, const std::vector<std::string>& known, const std::string& where) {
  if (!json.is_object()) throw Error(where + ": no JSON object; expected {\"" + known.front() + "\": …}");
  for (const auto& [key, value] : json.items()) {
    if (std::find(known.begin(), known.end(), key) == known.end()) {
      const std::string nearest = nearest_name(key, known);
      throw Error(nearest.empty() ? fmt::format("{}: '{}' is unknown; expected one of {}", where, key, fmt::join(known, ", "))
                                  : fmt::format("{}: '{}' is unknown; the nearest is '{}'", where, key, nearest));
    }
  }
}

std::string text_member(const nlohmann::json& json, const std::string& key, const std::string& where) {
  if (json.contains(key) && !json[key].is_string())
    throw Error(fmt::format("{}: '{}' is {}; expected a text", where, key, json[key].dump()));
  return member<std::string>(json, key, where);
}

SessionPlan::Object read_object(const nlohmann::json& json, const std::string& where) {
  check_keys(json, {"name", "runs"}, where);
  SessionPlan::Object object{.name = text_member(json, "name", where), .runs = 1};
  if (const std::string why = why_not_an_object_name(object.name); !why.empty()) throw Error(where + ": " + why);
  if (json.contains("runs")) {
    if (!json["runs"].is_number_integer() || json["runs"] < 1 || json["runs"] > 99) {
      throw Error(fmt::format("{}: 'runs' is {}; expected a whole number from 1 to 99", where, json["runs"].dump()));
    }
    object.runs = json["runs"].get<int>();
  }
  return object;
}

std::optional<RobotBit> read_bit(const nlohmann::json& json, const std::string& key, const std::string& where) {
  if (!json.contains(key)) return {};
  const std::string text = text_member(json, key, where);
  try {
    return robot_bit(text);
  } catch (const Error& e) {
    throw Error(fmt::format("{}: '{}': {}", where, key, e.what()));
  }
}

bool ended_as_planned(const RunInfo& run, const SessionPlan& plan) {
  const auto ended = run.extra.find("ended");
  if (ended == run.extra.end() || !ended->is_string()) return true;  // recorded by another program, which only writes `complete`
  const auto& why = ended->get_ref<const std::string&>();
  const bool has_an_end = plan.duration_s || plan.stop_on;
  return why != "interrupted" && !why.starts_with("source gone") && !(plan.duration_s && why == "source ended") &&
         !(has_an_end && why == "stopped on the page");
}

}  // namespace

SessionPlan read_session_plan(const fs::path& file) {
  const nlohmann::json json = read_json(file);
  const std::string where = file.string();
  check_keys(json, {"session", "objects", "duration", "start_on", "stop_on"}, where);
  SessionPlan plan;
  if (json.contains("session")) plan.name = text_member(json, "session", where);
  if (!json.contains("objects") || !json["objects"].is_array() || json["objects"].empty()) {
    throw Error(where + ": no 'objects'; expected a list such as [{\"name\": \"fan\", \"runs\": 10}]");
  }
  for (const nlohmann::json& entry : json["objects"]) {
    plan.objects.push_back(read_object(entry, fmt::format("{}: object {}", where, plan.objects.size() + 1)));
    const std::string& name = plan.objects.back().name;
    if (std::count_if(plan.objects.begin(), plan.objects.end(), [&](const auto& o) { return o.name == name; }) > 1) {
      throw Error(fmt::format("{}: '{}' is listed twice; expected each object once", where, name));
    }
  }
  if (json.contains("duration")) {
    if (json["duration"].is_number()) plan.duration_s = json["duration"].get<double>();
    if (!plan.duration_s || !std::isfinite(*plan.duration_s) || *plan.duration_s <= 0 || *plan.duration_s > 1e9) {
      throw Error(fmt::format("{}: 'duration' is {}; expected seconds above 0", where, json["duration"].dump()));
    }
  }
  plan.start_on = read_bit(json, "start_on", where);
  plan.stop_on = read_bit(json, "stop_on", where);
  return plan;
}

int complete_runs(const fs::path& data, const SessionPlan& plan, const std::string& object) {
  if (!is_there(data)) return 0;
  const std::vector<RunFolder> runs = find_runs(data);
  return static_cast<int>(std::count_if(runs.begin(), runs.end(), [&](const RunFolder& run) {
    if (run.object != object) return false;
    try {
      const RunInfo info = read_run_info(run);
      return info.complete && ended_as_planned(info, plan);
    } catch (const Error&) {
      return false;
    }
  }));
}

}  // namespace tactile::capture
