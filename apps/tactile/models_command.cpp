#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "command.hpp"
#include "commands.hpp"
#include "experiment_output.hpp"
#include "option_checks.hpp"
#include "quantity_text.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/evaluation/tick_speed.hpp"
#include "tactile/model/bundle/model_bundle.hpp"
#include "tactile/model/bundle/pinned_bundle.hpp"
#include "tactile/review/model_list.hpp"
#include "text_table.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct ModelsArguments {
  std::string action = "list";
  std::vector<std::string> names;
  std::string models = "models";
  bool verbose = false;
};

std::uint64_t bytes_below(const fs::path& folder) {
  std::uint64_t bytes = 0;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) bytes += entry.file_size();
  return bytes;
}

/// As `review::models_json`, with the size of each bundle, whether it is pinned, and the time of a tick as `eval` measured it.
json listed(const fs::path& models) {
  const auto pinned = model::pinned_bundle(models);
  json list = review::models_json(models);
  for (json& entry : list) {
    const std::string name = entry.at("name");
    entry["bytes"] = bytes_below(models / name);
    entry["pinned"] = pinned && pinned->name() == name;
    const fs::path speed = evaluation::speed_file({models / name});
    entry["speed"] = is_file(speed) ? read_json(speed) : json();
  }
  return list;
}

const json& entry_of(const json& list, const std::string& name, const std::string& models) {
  const auto found = std::find_if(list.begin(), list.end(), [&](const json& entry) { return entry.at("name") == name; });
  if (found == list.end()) throw Error(models + "/" + name + ": is no model; expected a name that 'tactile models' lists");
  return *found;
}

/// What a model was found to do: names and texts, the same for every model.
std::vector<std::pair<std::string, std::string>> figures_of(const json& entry) {
  const json &eval = entry.at("eval"), &speed = entry.at("speed");
  const auto text = [&](const char* key, double scale) { return eval.is_null() ? "-" : figure_text(eval.at(key), scale, 1); };
  return {{"accuracy [%]", text("accuracy", 100)},
          {"press delay, median [ms]", text("press_delay_ms", 1)},
          {"slip delay, median [ms]", text("slip_delay_ms", 1)},
          {"presses missed [%]", eval.is_null() ? "-" : figure_text(eval.at("missed").at("press"), 100, 1)},
          {"slips missed [%]", eval.is_null() ? "-" : figure_text(eval.at("missed").at("slip"), 100, 1)},
          {"false alarms [1/min]", text("false_alarms_per_min", 1)},
          {"size", bytes_text(entry.at("bytes").get<std::uint64_t>())},
          {"time per tick [us]", speed.is_null() ? "-"
                                                 : fmt::format("{:.0f}, 99 % within {:.0f}", speed.at("us_p50").get<double>(),
                                                               speed.at("us_p99").get<double>())}};
}

std::string shown_value(const json& value) { return value.is_string() ? value.get<std::string>() : value.dump(); }

/// "data/dataset.h5, 1a2b3c4d"
std::string dataset_text(const json& of) {
  return shown_value(of.at("dataset")) + ", " + of.at("manifest_hash").get<std::string>().substr(0, 8);
}

/// Whether the results are of other data, or another state of the data, than that which the model learned from.
bool is_judged_on_other_data(const json& entry) {
  return !entry.at("eval").is_null() && entry.at("eval").at("manifest_hash") != entry.at("trained").at("manifest_hash");
}

std::string list_text(const json& list, const std::string& models) {
  if (list.empty()) return models + ": no model; 'tactile train' makes one\n";
  std::vector<std::vector<std::string>> rows;
  bool any_on_other = false;
  for (const json& entry : list) {
    if (!entry.at("error").is_null()) {
      rows.push_back({entry.at("name"), "", "", "", "", shown_value(entry.at("error"))});
      continue;
    }
    const auto figures = figures_of(entry);
    rows.push_back({entry.at("name"), figures[0].second, figures[1].second, figures[2].second, figures[5].second,
                    std::string(entry.at("pinned").get<bool>() ? "pinned " : "") + (is_judged_on_other_data(entry) ? "*" : "")});
    any_on_other = any_on_other || is_judged_on_other_data(entry);
  }
  return text_table({"model", "accuracy [%]", "press [ms]", "slip [ms]", "alarms/min", ""}, rows) +
         "In brackets: 95 % intervals; -: 'tactile eval --model NAME' has not judged it.\n" +
         (any_on_other ? "*: judged on other data than it learned from, on runs that it has not seen.\n" : "");
}

std::string show_text(const json& entry) {
  if (!entry.at("error").is_null()) return shown_value(entry.at("error")) + "\n";
  std::string text = entry.at("name").get<std::string>() + (entry.at("pinned").get<bool>() ? ", pinned" : "") + "\n\n";
  const json& trained = entry.at("trained");
  std::vector<std::pair<std::string, std::string>> lines{
      {"kind", shown_value(entry.at("kind"))},
      {"trained",
       fmt::format("{} on {}, {} {} runs, {} samples", shown_value(trained.at("when")).substr(0, 16), dataset_text(trained),
                   trained.at("runs").size(), trained.at("simulated").get<bool>() ? "simulated" : "real",
                   trained.at("samples").get<std::uint64_t>())}};
  for (const auto& [path, value] : entry.at("settings").items()) lines.emplace_back(path, shown_value(value));
  if (!entry.at("eval").is_null()) lines.emplace_back("judged on", dataset_text(entry.at("eval")));
  for (const auto& figure : figures_of(entry)) lines.push_back(figure);
  return text + text_list(lines);
}

/// Settings and data that differ between the models, and what they were found to do, side by side.
/// @param all  also settings that none of the models has: models of two kinds have few in common
std::string comparison_text(const std::vector<json>& entries, bool all) {
  std::vector<std::string> header{""};
  std::set<std::string> paths;
  for (const json& entry : entries) {
    if (!entry.at("error").is_null()) throw Error(shown_value(entry.at("error")));
    header.push_back(entry.at("name"));
    for (const auto& [path, value] : entry.at("settings").items()) paths.insert(path);
  }
  std::vector<std::vector<std::string>> rows;
  const auto add = [&](const std::string& name, const auto& text_in) {
    std::vector<std::string> row{name};
    for (const json& entry : entries) row.push_back(text_in(entry));
    const bool differs = std::any_of(row.begin() + 1, row.end(), [&](const std::string& cell) { return cell != row[1]; });
    const bool is_set =
        std::any_of(row.begin() + 1, row.end(), [](const std::string& cell) { return cell != "null" && cell != "default"; });
    if (differs && (all || is_set)) rows.push_back(std::move(row));
  };
  add("kind", [](const json& entry) { return shown_value(entry.at("kind")); });
  for (const std::string& path : paths) {
    add(path, [&](const json& entry) {
      return entry.at("settings").contains(path) ? shown_value(entry.at("settings").at(path)) : std::string("default");
    });
  }
  const std::size_t settings = rows.size();
  add("learned from", [](const json& entry) { return dataset_text(entry.at("trained")); });
  add("runs", [](const json& entry) { return std::to_string(entry.at("trained").at("runs").size()); });
  add("samples", [](const json& entry) { return entry.at("trained").at("samples").dump(); });
  add("judged on",
      [](const json& entry) { return entry.at("eval").is_null() ? std::string("-") : dataset_text(entry.at("eval")); });
  for (std::size_t i = 0; i < figures_of(entries.front()).size(); ++i) {
    std::vector<std::string> row{figures_of(entries.front())[i].first};
    for (const json& entry : entries) row.push_back(figures_of(entry)[i].second);
    rows.push_back(std::move(row));
  }
  return text_table(header, rows) + (settings == 0 ? "All settings are the same.\n" : "");
}

/// Removes whole bundles, results included. @throws Error  before anything is removed, if one is no model or is pinned
void remove(const ModelsArguments& args, const json& list) {
  for (const std::string& name : args.names) {
    if (entry_of(list, name, args.models).at("pinned").get<bool>())
      throw Error(name + ": is pinned; run 'tactile models unpin' first");
  }
  for (const std::string& name : args.names) fs::remove_all(fs::path(args.models) / name);
}

/// How many names an action takes.
void check_names(const ModelsArguments& args) {
  const std::size_t given = args.names.size();
  const auto expect = [&](bool right, const char* expected) {
    if (!right) throw Error(fmt::format("{}: takes {}; {} given", args.action, expected, given));
  };
  if (args.action == "list" || args.action == "unpin") expect(given == 0, "no name");
  if (args.action == "show" || args.action == "pin") expect(given == 1, "one name");
  if (args.action == "compare") expect(given >= 2, "two names or more");
  if (args.action == "rm") expect(given >= 1, "one name or more");
}

void run_models(const ModelsArguments& args, const CommonArguments& common) {
  check_names(args);
  if (args.action == "unpin") {
    const std::string name = model::unpin_bundle(args.models);
    return print_result(common, {{"unpinned", name.empty() ? json() : json(name)}},
                        name.empty() ? "No model is pinned.\n" : name + ": no longer pinned\n");
  }
  if (args.action == "pin") {
    model::pin_bundle(args.models, args.names.front());
    return print_result(
        common, {{"pinned", args.names.front()}},
        wrapped(args.names.front() + ": pinned; detect, eval, export, report and stress take it if no --model is given") + "\n");
  }
  const json list = listed(args.models);
  if (args.action == "list") return print_result(common, {{"models", list}}, list_text(list, args.models));
  std::vector<json> entries;
  for (const std::string& name : args.names) entries.push_back(entry_of(list, name, args.models));
  if (args.action == "rm") {
    remove(args, list);
    return print_result(common, {{"removed", args.names}}, fmt::format("removed {}\n", fmt::join(args.names, ", ")));
  }
  print_result(common, {{"models", entries}},
               args.action == "show" ? show_text(entries.front()) : comparison_text(entries, args.verbose));
}

}  // namespace

void add_models_command(CLI::App& app) {
  auto args = std::make_shared<ModelsArguments>();
  Command command = add_command(app, "models", "List, compare, pin and remove models",
                                [args](const CommonArguments& common) { run_models(*args, common); });
  command
      .add_option("action", args->action,
                  "list: all models; show: one; compare: two or more; pin: make this the default model; unpin; rm: remove")
      .check(one_of({"list", "show", "compare", "pin", "unpin", "rm"}))
      .show_default();
  command.add_option("names", args->names, "Names of models, as 'list' shows them").type_name("MODEL");
  command.add_option("--models", args->models, "Folder of models").type_name("DIR").show_default();
  command.add_flag("--verbose", args->verbose, "With compare: also settings that none of the models uses");
}

}  // namespace tactile::cli
