#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "chosen_model.hpp"
#include "command.hpp"
#include "commands.hpp"
#include "quantity_text.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/model/bundle/exported_network.hpp"
#include "tactile/model/bundle/onnx_model.hpp"
#include "tactile/model/bundle/temperature.hpp"
#include "tactile/model/definition/model_network.hpp"
#include "text_table.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;

struct ExportArguments {
  std::string model, models = "models";
  std::string onnx, safetensors;
  bool force = false;

  /// NAME.json beside NAME.onnx: what the network reads. Empty without an ONNX file.
  std::string description() const { return onnx.empty() ? "" : model::own_description_file(onnx).string(); }
};

struct ExportedFile {
  std::string format;
  fs::path file;
  std::uint64_t bytes = 0;
  std::string sha256;
};

/// Checks everything before the first file is written.
void check_places(const ExportArguments& args) {
  if (args.onnx.empty() && args.safetensors.empty()) {
    throw Error("no output is given; expected --onnx FILE, --safetensors FILE, or both");
  }
  const auto place = [](const std::string& file) { return fs::weakly_canonical(fs::absolute(file)); };
  if (!args.onnx.empty() && !args.safetensors.empty() && place(args.onnx) == place(args.safetensors)) {
    throw Error(args.onnx + ": is given for both formats; expected a file for each");
  }
  for (const std::string& file : {args.onnx, args.safetensors}) {
    if (!file.empty() && !args.onnx.empty() && place(file) == place(args.description()))
      throw Error(file + ": is the file that says what the ONNX model reads; expected another name, such as NAME.onnx");
  }
  for (const std::string& file : {args.onnx, args.description(), args.safetensors}) {
    if (file.empty() || !fs::exists(fs::symlink_status(file))) continue;
    if (fs::is_directory(file)) throw Error(file + ": is a folder; expected the name of a file");
    if (!args.force) throw Error(file + ": exists already; expected a new name, or --force to replace it");
  }
}

nlohmann::json json_of(const std::vector<ExportedFile>& files) {
  nlohmann::json json = nlohmann::json::array();
  for (const ExportedFile& file : files)
    json.push_back({{"format", file.format}, {"file", file.file.string()}, {"bytes", file.bytes}, {"sha256", file.sha256}});
  return json;
}

std::string input_words(const model::ModelDescription& model) {
  if (model.settings.kind == model::ModelKind::stream)
    return fmt::format("Input: counts of the {}, and the states", input_text(model.settings.kind, model.input));
  return fmt::format("Input: float32 [n, 1, {}, {}], a heatmap / 255", model.input.height, model.input.width);
}

/// What `--json` prints. @param network  what the ONNX file reads and gives; null without one
nlohmann::json export_json(const model::ModelBundle& bundle, const model::ModelDescription& model,
                           const std::map<std::string, std::string>& metadata, double temperature,
                           const std::vector<ExportedFile>& files, const nlohmann::json& network) {
  nlohmann::json json = {
      {"model", bundle.folder.string()},
      {"name", bundle.name()},
      {"simulated", model.simulated},
      {"weights_sha256", model.weights_sha256},
      {"temperature", temperature},
      {"classes", nlohmann::json::parse(metadata.at("classes"))},
      {"input", nlohmann::json::parse(metadata.at("input"))},
      {"settings", {{"rendering", model.settings.rendering}, {"network", nlohmann::json(model.settings).at("network")}}},
      {"parameters", model::network_json(model.settings, model.input).at("parameters")},
      {"files", json_of(files)}};
  if (network.is_null()) {
    json["onnx"] = nullptr;
    return json;
  }
  json["onnx"] = {{"ir_version", model::onnx_ir_version},
                  {"opset", model::onnx_opset},
                  {"input", network.at("input").at("name")},
                  {"states", network.at("states")},
                  {"outputs", {"logits", "probabilities"}}};
  return json;
}

void export_model(const ExportArguments& args, const CommonArguments& common) {
  check_places(args);
  const ChosenModel chosen = chosen_model(args.model, args.models);
  const model::ModelBundle& bundle = chosen.bundle;
  const model::ModelDescription model = model::read_description(bundle);
  if (args.model.empty()) log_choice("exporting", chosen);
  const model::Weights weights = model::read_bundle_weights(bundle, model);
  auto metadata = model::weights_metadata(model);
  metadata["model"] = bundle.name();
  const double temperature = model::read_temperature(bundle, model).value;
  metadata["temperature"] = fmt::format("{}", temperature);

  nlohmann::json network;
  if (!args.onnx.empty()) network = model::exported_description(model, weights, temperature);

  const IfThere if_there = args.force ? IfThere::replace : IfThere::refuse;
  std::optional<WholeFile> onnx, description, safetensors;
  std::vector<ExportedFile> files;
  const auto written = [&](const std::string& format, const fs::path& file, const WholeFile& whole) {
    files.push_back({format, file, fs::file_size(whole.path()), sha256_of_file(whole.path())});
  };
  if (!args.onnx.empty()) {
    auto about = metadata;
    about.erase("format");  // of safetensors only
    about["weights_sha256"] = model.weights_sha256;
    if (model.settings.kind == model::ModelKind::stream) {
      for (const char* key : {"input", "states", "grid"}) about[key] = network.at(key).dump();
    }
    onnx.emplace(args.onnx, if_there);
    write_whole(onnx->path(), model::exported_onnx(model, weights, bundle.name(), about));
    written("onnx", args.onnx, *onnx);
    description.emplace(args.description(), if_there);
    write_json(description->path(), network);
    written("json", args.description(), *description);
  }
  if (!args.safetensors.empty()) {
    safetensors.emplace(args.safetensors, if_there);
    model::write_weights(safetensors->path(), weights, metadata);
    written("safetensors", args.safetensors, *safetensors);
  }
  stop_if_interrupted();
  if (onnx) onnx->commit();
  if (description) description->commit();
  if (safetensors) safetensors->commit();

  const nlohmann::json json = export_json(bundle, model, metadata, temperature, files, network);
  std::vector<std::vector<std::string>> rows;
  rows.reserve(files.size());
  for (const ExportedFile& file : files) rows.push_back({file.file.string(), file.format, bytes_text(file.bytes)});
  std::string text = text_table({"file", "format", "size"}, rows) + "\n";
  text += wrapped(fmt::format("{}: trained on {} runs. {}; output: the logits of none, press, slip", bundle.folder.string(),
                              model.simulated ? "simulated" : "real", input_words(model))) +
          "\n";
  print_result(common, json, text);
}

}  // namespace

void add_export_command(CLI::App& app) {
  auto args = std::make_shared<ExportArguments>();
  Command command = add_command(app, "export", "Write a model in formats that other software reads",
                                [args](const CommonArguments& common) { export_model(*args, common); });
  command.add_option("--model", args->model, default_model_help);
  command.add_option("--models", args->models, "Folder of models").type_name("DIR").show_default();
  command.add_option("--onnx", args->onnx, "Write an ONNX model, network and weights, and NAME.json, what it reads")
      .type_name("FILE");
  command.add_option("--safetensors", args->safetensors, "Write only the weights, as safetensors").type_name("FILE");
  command.add_flag("--force", args->force, "Replace existing files");
}

}  // namespace tactile::cli
