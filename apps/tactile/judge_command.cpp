#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "command.hpp"
#include "commands.hpp"
#include "option_checks.hpp"
#include "tactile/core/error.hpp"
#include "tactile/experiments/study/sample_confusions.hpp"

namespace tactile::cli {
namespace {

struct JudgeArguments {
  std::string dataset, model, out, engine = "fast";
  std::vector<std::string> runs;
};

void judge(const JudgeArguments& args, const CommonArguments& common) {
  const windows::Dataset dataset(args.dataset);
  study::SampleJudgement judgement{
      .bundle = args.model, .runs = {}, .engine = model::engine_named(args.engine), .threads = common.threads};
  for (const std::string& name : args.runs) {
    const auto runs = dataset.runs();
    const auto found = std::find_if(runs.begin(), runs.end(), [&](const auto& run) { return name_of(run) == name; });
    if (found == runs.end()) throw Error(args.dataset + ": has no run " + name + "; expected one of its runs");
    judgement.runs.push_back(static_cast<std::uint32_t>(found - runs.begin()));
  }
  study::judge_samples(dataset, judgement, args.out, progress_line(common));
}

}  // namespace

void add_judge_command(CLI::App& app) {
  auto args = std::make_shared<JudgeArguments>();
  Command command = add_command(app, "judge", "Judge a model on the samples of runs: a part of a study",
                                [args](const CommonArguments& common) { judge(*args, common); });
  command.add_option("dataset", args->dataset, "Dataset file").type_name("FILE.h5").required();
  command.add_option("--model", args->model, "Model bundle").type_name("DIR").required();
  command.add_option("--runs", args->runs, "Runs to judge on").type_name("RUN...").required();
  command.add_option("--out", args->out, "File of the result").type_name("FILE.json").required();
  command.add_option("--engine", args->engine, "Engine: fast or libtorch").check(one_of({"fast", "libtorch"})).show_default();
  command.hide();  // only 'reproduce' starts it
}

}  // namespace tactile::cli
