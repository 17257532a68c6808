#include <memory>
#include <string>
#include <vector>

#include "command.hpp"
#include "commands.hpp"
#include "option_checks.hpp"
#include "tactile/experiments/study/judge_models.hpp"

namespace tactile::cli {
namespace {

struct JudgeArguments {
  std::string dataset, model, out, engine = "fast";
  std::vector<std::string> runs;
  bool whole = false, baselines = false;
};

void judge(const JudgeArguments& args, const CommonArguments& common) {
  study::judge({.dataset = args.dataset,
                .bundle = args.model,
                .out = args.out,
                .runs = args.runs,
                .whole = args.whole,
                .baselines = args.baselines,
                .engine = model::engine_named(args.engine),
                .threads = common.threads},
               progress_line(common));
}

}  // namespace

void add_judge_command(CLI::App& app) {
  auto args = std::make_shared<JudgeArguments>();
  Command command = add_command(app, "judge", "Judge a model on runs: a part of a study",
                                [args](const CommonArguments& common) { judge(*args, common); });
  command.add_option("dataset", args->dataset, "Dataset file").type_name("FILE.h5").required();
  command.add_option("--model", args->model, "Model bundle").type_name("DIR").required();
  command.add_option("--runs", args->runs, "Runs to judge on").type_name("RUN...");
  command.add_option("--out", args->out, "Table of cells").type_name("FILE.csv").required();
  command.add_flag("--whole", args->whole, "Judge whole runs, also those without samples; else samples only");
  command.add_flag("--baselines", args->baselines, "Judge published detectors too");
  command.add_option("--engine", args->engine, "Engine: fast or libtorch").check(one_of({"fast", "libtorch"})).show_default();
  command.hide();  // only 'reproduce' starts it
}

}  // namespace tactile::cli
