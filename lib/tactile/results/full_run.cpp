#include "tactile/results/full_run.hpp"

#include "tactile/core/error.hpp"

namespace tactile::results {

void to_json(nlohmann::json& json, const FullRun& run) {
  std::string digits;
  for (const Touch touch : run.verdicts) digits += static_cast<char>('0' + static_cast<int>(touch));
  json = {{"run", run.run},
          {"first_us", us_of(run.ticks.first)},
          {"tick_us", run.ticks.tick.count()},
          {"said", digits},
          {"events", run.events}};
}

void from_json(const JsonView& json, FullRun& run) {
  run.run = json["run"].text();
  run.ticks.first = camera_time(json["first_us"].whole_number());
  run.ticks.tick = microseconds{json["tick_us"].whole_number()};
  run.events = json["events"].counts();
  const JsonView digits = json["said"];
  for (const char digit : digits.text()) {
    if (digit < '0' || digit > '2') throw Error(digits.where() + " has a digit other than 0, 1 and 2");
    run.verdicts.push_back(static_cast<Touch>(digit - '0'));
  }
  run.ticks.count = static_cast<std::int64_t>(run.verdicts.size());
  if (run.events.size() != run.verdicts.size() || run.ticks.tick <= microseconds{0})
    throw Error(json.where() + ": the numbers of verdicts and event counts differ; expected a full run of a model");
}

}  // namespace tactile::results
