#include <memory>
#include <string>
#include <vector>

#include "command.hpp"
#include "commands.hpp"
#include "model_arguments.hpp"
#include "tactile/experiments/study/judge_models.hpp"

namespace tactile::cli {

void add_judge_command(CLI::App& app) {
  auto judgement = std::make_shared<study::Judgement>();
  Command command =
      add_command(app, "judge", "Judge a model on runs: a part of a study", [judgement](const CommonArguments& common) {
        judgement->threads = common.threads;
        study::judge(*judgement, progress_line(common));
      });
  command.add_path_option("dataset", judgement->dataset, "Dataset file").type_name("FILE.h5").required();
  command.add_path_option("--model", judgement->bundle, "Model bundle").type_name("DIR").required();
  command.add_option("--runs", judgement->runs, "Runs to judge on").type_name("RUN...");
  command.add_path_option("--out", judgement->out, "Table of cells").type_name("FILE.csv").required();
  command.add_flag("--whole", judgement->whole, "Judge whole runs, also those without samples; else samples only");
  command.add_flag("--baselines", judgement->baselines, "Judge published detectors too");
  add_engine_option(command, judgement->engine);
  command.hide();  // only 'reproduce' starts it
}

}  // namespace tactile::cli
