#include <fmt/core.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "chosen_model.hpp"
#include "command.hpp"
#include "commands.hpp"
#include "field_options.hpp"
#include "interruption.hpp"
#include "label_pictures.hpp"
#include "option_checks.hpp"
#include "run_places.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/process.hpp"
#include "tactile/evaluation/full_run.hpp"
#include "tactile/labels/saved_labels.hpp"
#include "tactile/model/inference/classifier.hpp"
#include "tactile/review/page_server.hpp"
#include "tactile/review/review.hpp"
#include "tactile/review/web_files.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;

struct ReviewArguments {
  std::vector<std::string> places{"data"};
  std::string host = "127.0.0.1";
  std::uint16_t port = 7790;
  bool open = false, no_pictures = false;
  std::string who, models = "models", studies = ".", pieces = "data";
  microseconds history{40'000};
};

/// The name of the model in the folder that commands take without --model.
std::optional<std::string> default_model(const std::string& models) {
  try {
    return chosen_model({}, models).bundle.name();
  } catch (const Error&) {
    return std::nullopt;
  }
}

results::FullRun classify(const fs::path& recording, const fs::path& bundle, const std::function<void(std::size_t)>& advance) {
  // One thread: the page is answered in the meantime.
  const model::Classifier classifier(bundle, 1);
  return evaluation::classify_full_run(recording, classifier, {.threads = 1, .advance = advance});
}

review::ReviewHelp review_help(const ReviewArguments& args) {
  review::ReviewHelp help{
      .classify = classify, .default_model = [models = args.models] { return default_model(models); }, .draw_labels = {}};
  if (!args.no_pictures) {
    help.draw_labels = [](const RunFolder& run, const labels::Labels&) {
      LabelPictures pictures;
      pictures.draw_again(run);
      pictures.warn_of_failures();
    };
  }
  return help;
}

review::ReviewOptions review_options(const ReviewArguments& args) {
  std::string data;
  for (const std::string& place : args.places) data += (data.empty() ? "" : ", ") + place;
  return {.data = data,
          .models = args.models,
          .studies = args.studies,
          .pieces = args.pieces,
          .who = args.who.empty() ? labels::system_user() : args.who,
          .history = args.history};
}

/// Shows the page in the user's browser.
ChildProcess open_in_browser(const std::string& url) {
  try {
    return ChildProcess({.program = "xdg-open", .arguments = {url}, .own_group = true});
  } catch (const std::system_error&) {
    throw Error("--open: there is no program xdg-open; expected it, or open the printed address yourself");
  }
}

void review_runs(const ReviewArguments& args, const CommonArguments& common) {
  runs_in(args.places);  // warns of folders that are left out, once
  review::Review review(review_options(args), review_help(args),
                        [places = args.places] { return runs_in(places, LeftOutFolders::say_nothing); });
  const review::PageServerOptions options{.host = args.host, .port = args.port};
  review::PageServer server(options, review::web_files(),
                            [&review](const review::PageRequest& request) { return review.answer(request); });
  print_result(common, {{"url", server.url()}, {"port", server.port()}}, server.url() + "\n");
  std::fflush(stdout);
  std::optional<ChildProcess> browser;
  if (args.open) browser = open_in_browser(server.url());
  while (!interrupted()) std::this_thread::sleep_for(std::chrono::milliseconds(50));
}

}  // namespace

void add_review_command(CLI::App& app) {
  auto args = std::make_shared<ReviewArguments>();
  Command command = add_command(
      app, "review", "See runs, correct their labels and compare models, on a local page in the browser",
      [args](const CommonArguments& common) { review_runs(*args, common); }, CtrlC::is_the_end);
  command.add_option("what", args->places, "Run folders, or folders of runs").type_name("DATA|RUN").show_default();
  command.add_option("--port", args->port, "Port of the page; 0 takes a free port")
      .check(in_range<std::uint16_t>(0, 65535))
      .type_name("N")
      .show_default();
  command
      .add_option("--host", args->host,
                  "Address to listen on; with 0.0.0.0 other machines reach the page, by the token in the printed address")
      .type_name("HOST")
      .show_default();
  command.add_flag("--open", args->open, "Open the page in the browser");
  command.add_option("--who", args->who, "Name of the person who edits; default: the user's name on this system")
      .type_name("NAME");
  command.add_option("--models", args->models, "Folder of models").type_name("DIR").show_default();
  command.add_option("--studies", args->studies, "Folder to search for results of reproduce, trade, stress and eval")
      .type_name("DIR")
      .show_default();
  command.add_option("--pieces", args->pieces, "Folder of runs for recordings that are cut on the page")
      .type_name("DATA")
      .show_default();
  add_duration(command, "--th", args->history, 1, 1'000'000, 1000, "History t_h of events and heatmap [ms]");
  command.add_flag("--no-pictures", args->no_pictures, "Do not draw labels.png after an edit");
}

}  // namespace tactile::cli
