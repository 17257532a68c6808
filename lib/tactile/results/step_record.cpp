#include "tactile/results/step_record.hpp"

namespace tactile::results {

void to_json(nlohmann::json& json, const StepRecord& step) {
  json = {
      {"name", step.name}, {"command", text_or_null(step.command)}, {"seconds", step.seconds}, {"finished_at", step.finished_at}};
}

void from_json(const JsonView& json, StepRecord& step) {
  step = {.name = json["name"].text(),
          .command = json["command"].text(),
          .seconds = json["seconds"].number(),
          .finished_at = json["finished_at"].text()};
}

}  // namespace tactile::results
