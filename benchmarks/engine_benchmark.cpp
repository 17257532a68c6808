#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <numeric>
#include <sstream>
#include <string>
#include <vector>

#include "answer_each_line.hpp"
#include "engine_limits.hpp"
#include "measured_time.hpp"
#include "onednn_lenet.hpp"
#include "tactile/core/random.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/model/bundle/model_bundle.hpp"
#include "tactile/model/inference/lenet_engine.hpp"
#include "tactile/model/training/lenet.hpp"
#include "tactile/model/training/train_model.hpp"
#include "tactile/windows/dataset.hpp"

// engine_benchmark heatmaps DATASET MODEL FOLDER
//   Writes groups of heatmaps, one file each, and FOLDER/groups.json.
// engine_benchmark accuracy DATASET MODEL
//   Compares bf16 and int8 with float32 on the test runs of the dataset.
// engine_benchmark ENGINE MODEL FOLDER
//   For each line "GROUP CALLS" of standard input: classifies CALLS heatmaps of the group one at a time, and prints the
//   microseconds per heatmap and the first logit of the first one.
//
// benchmarks/engine_peers.py compares it with the same network in other frameworks.

namespace {

using namespace tactile;
using namespace tactile::bench;
namespace fs = std::filesystem;
using Heatmap = std::vector<std::uint8_t>;

constexpr std::size_t group_size = 16;

double lit_share(std::span<const std::uint8_t> heatmap) {
  return 1 - static_cast<double>(std::count(heatmap.begin(), heatmap.end(), 0)) / static_cast<double>(heatmap.size());
}

double mean_share(const std::vector<Heatmap>& heatmaps) {
  double sum = 0;
  for (const Heatmap& heatmap : heatmaps) sum += lit_share(heatmap);
  return sum / static_cast<double>(heatmaps.size());
}

/// Heatmaps of press and slip in the dataset, sorted by the share of lit cells.
std::vector<Heatmap> heatmaps_in_action(const windows::Dataset& dataset, const model::ModelDescription& model) {
  std::vector<std::uint32_t> indexes;
  for (std::uint32_t i = 0; i < dataset.samples().size(); ++i) {
    if (dataset.samples()[i].touch != Touch::none) indexes.push_back(i);
  }
  const auto all = model::sample_heatmaps(dataset, model.settings.rendering, indexes, 1);
  const std::size_t cells = all.size() / indexes.size();
  std::vector<Heatmap> heatmaps;
  for (std::size_t i = 0; i < indexes.size(); ++i) heatmaps.emplace_back(&all[i * cells], &all[i * cells] + cells);
  std::stable_sort(heatmaps.begin(), heatmaps.end(),
                   [](const Heatmap& a, const Heatmap& b) { return lit_share(a) < lit_share(b); });
  return heatmaps;
}

/// Heatmaps whose lit cells are anywhere.
std::vector<Heatmap> noise_like(std::size_t cells, double share) {
  Random random(1);
  std::vector<Heatmap> heatmaps(group_size, Heatmap(cells));
  for (Heatmap& heatmap : heatmaps) {
    for (std::uint8_t& cell : heatmap)
      cell = static_cast<double>(random.below(1'000'000)) < share * 1e6 ? static_cast<std::uint8_t>(1 + random.below(255))
                                                                        : std::uint8_t{0};
  }
  return heatmaps;
}

/// Heatmaps in action with a given share of lit cells: only the lit cells closest to the centre are kept. If a heatmap has too
/// few, the maximum of several heatmaps is used.
std::vector<Heatmap> marker_like(const std::vector<Heatmap>& in_action, events::SensorSize size, double share) {
  Random random(2);
  std::vector<Heatmap> heatmaps;
  const auto wanted = static_cast<std::size_t>(share * static_cast<double>(in_action.front().size()));
  std::vector<std::size_t> by_distance(in_action.front().size());
  std::iota(by_distance.begin(), by_distance.end(), std::size_t{0});
  const auto distance = [&](std::size_t i) {
    const auto width = static_cast<std::size_t>(size.width);
    return std::hypot(static_cast<double>(i % width) - size.width / 2.0, static_cast<double>(i / width) - size.height / 2.0);
  };
  std::stable_sort(by_distance.begin(), by_distance.end(),
                   [&](std::size_t a, std::size_t b) { return distance(a) < distance(b); });
  while (heatmaps.size() < group_size) {
    Heatmap laid = in_action[in_action.size() / 2];
    while (lit_share(laid) < share) {
      const Heatmap& other = in_action[random.below(in_action.size())];
      for (std::size_t i = 0; i < laid.size(); ++i) laid[i] = std::max(laid[i], other[i]);
    }
    Heatmap kept(laid.size());
    std::size_t lit = 0;
    for (std::size_t i = 0; i < laid.size() && lit < wanted; ++i) {
      kept[by_distance[i]] = laid[by_distance[i]];
      lit += kept[by_distance[i]] != 0 ? 1 : 0;
    }
    heatmaps.push_back(std::move(kept));
  }
  return heatmaps;
}

void write_heatmaps(const fs::path& dataset_file, const fs::path& bundle, const fs::path& folder) {
  const windows::Dataset dataset(dataset_file);
  const model::ModelDescription model = model::read_description({bundle});
  const auto in_action = heatmaps_in_action(dataset, model);
  const std::size_t cells = in_action.front().size(), middle = in_action.size() / 2;
  nlohmann::json groups = nlohmann::json::object();
  fs::create_directories(folder);
  const auto write = [&](const std::string& name, const std::vector<Heatmap>& heatmaps) {
    std::string text;
    for (const Heatmap& heatmap : heatmaps) text.append(heatmap.begin(), heatmap.end());
    write_whole(folder / (name + ".bin"), text);
    groups[name] = mean_share(heatmaps);
  };
  write("action", {in_action.begin() + static_cast<std::ptrdiff_t>(middle - group_size / 2),
                   in_action.begin() + static_cast<std::ptrdiff_t>(middle + group_size / 2)});
  write("empty", std::vector<Heatmap>(group_size, Heatmap(cells)));
  for (const double share : {0.0002, 0.001, 0.005, 0.02, 0.05, 0.1, 0.2, 0.5}) {
    write(fmt::format("noise-{}", share), noise_like(cells, share));
    write(fmt::format("marker-{}", share), marker_like(in_action, model.input, share));
  }
  write_whole(folder / "groups.json",
              nlohmann::json{{"height", model.input.height}, {"width", model.input.width}, {"groups", groups}}.dump(2) + "\n");
}

/// Prints the accuracies of each precision on the samples of the test runs, and how far they differ from float32.
void print_accuracies(const fs::path& dataset_file, const fs::path& bundle) {
  const windows::Dataset dataset(dataset_file);
  const model::ModelDescription model = model::read_description({bundle});
  const model::Weights weights = model::read_bundle_weights({bundle}, model);
  struct Rounded {
    model::Precision precision;
    model::LeNetEngine engine;
    std::size_t right = 0, other = 0;
    double largest_difference = 0;
  };
  model::LeNetEngine exact(model.input, weights, model.settings.network);
  std::vector<Rounded> rounded;
  for (const auto precision : {model::Precision::bf16, model::Precision::int8})
    rounded.push_back({precision, {model.input, weights, model.settings.network, {.precision = precision}}});
  std::size_t samples = 0, right = 0;
  for (const std::uint32_t run : model::split_of(dataset, model.settings.split).test_runs) {
    const auto indexes = model::samples_of_runs(dataset, {&run, 1});
    const auto heatmaps = model::sample_heatmaps(dataset, model.settings.rendering, indexes, 1);
    const std::size_t cells = indexes.empty() ? 0 : heatmaps.size() / indexes.size();
    for (std::size_t i = 0; i < indexes.size(); ++i) {
      const auto heatmap = std::span(heatmaps).subspan(i * cells, cells);
      const model::Logits of_exact = exact.classify(heatmap);
      const Touch truth = dataset.samples()[indexes[i]].touch;
      ++samples;
      right += model::verdict_of(of_exact) == truth ? 1 : 0;
      for (Rounded& one : rounded) {
        const model::Logits of_one = one.engine.classify(heatmap);
        one.right += model::verdict_of(of_one) == truth ? 1 : 0;
        one.other += model::verdict_of(of_exact) != model::verdict_of(of_one) ? 1 : 0;
        for (std::size_t k = 0; k < touch_count; ++k)
          one.largest_difference =
              std::max(one.largest_difference, std::abs(static_cast<double>(of_exact[k]) - static_cast<double>(of_one[k])));
      }
    }
  }
  for (const Rounded& one : rounded) {
    fmt::print(
        "{} on {} balanced samples of test runs: {:.3f} % predicted correctly, {:.3f} % in float32; {} predictions differ; "
        "logits differ by up to {:.4f}\n",
        model::name_of(one.precision), samples, 100.0 * static_cast<double>(one.right) / static_cast<double>(samples),
        100.0 * static_cast<double>(right) / static_cast<double>(samples), one.other, one.largest_difference);
  }
}

using Work = std::function<float(const Heatmap&, const std::vector<float>&)>;

Work work_of(const std::string& kind, const model::ModelDescription& model, const model::Weights& weights) {
  const model::LeNetLayers layers = model::lenet_layers(model.input);
  const auto engine = [&](const model::EngineOptions& options) -> Work {
    return [engine = model::LeNetEngine(model.input, weights, model.settings.network, options)](
               const Heatmap& heatmap, const std::vector<float>&) mutable { return engine.classify(heatmap)[0]; };
  };
  if (kind == "fast") return engine({});
  if (kind == "dense") return engine({.skip_empty = false});
  if (kind == "bf16" || kind == "int8") return engine({.precision = model::precision_named(kind)});
  if (kind.starts_with("fast-")) return engine({.target = kind.substr(5)});
  if (kind == "libtorch") {
    const auto network = std::make_shared<model::LeNet>(model.input, weights, model.settings.network);
    return [network](const Heatmap& heatmap, const std::vector<float>&) { return network->logits(heatmap, 1)[0][0]; };
  }
  if (kind == "reading") {
    return
        [values = weights[4].values](const Heatmap&, const std::vector<float>&) { return sum_of(values.data(), values.size()); };
  }
  if (kind == "multiply-adds") {
    const auto outputs = [](events::SensorSize size) {
      return static_cast<std::size_t>(4 * size.width) * static_cast<std::size_t>(size.height);
    };
    const std::size_t count = outputs(layers.first_pooled) * weights[0].values.size() +
                              outputs(layers.second_pooled) * weights[2].values.size() + weights[4].values.size() +
                              weights[6].values.size() + weights[8].values.size();
    return [count](const Heatmap&, const std::vector<float>&) { return multiply_adds(count); };
  }
#ifdef TACTILE_HAS_ONEDNN
  if (kind == "onednn") {
    const auto network = std::make_shared<OneDnnLeNet>(layers, weights);
    return [network](const Heatmap&, const std::vector<float>& input) {
      model::Logits logits;
      network->classify(input.data(), logits.data());
      return logits[0];
    };
  }
#endif
  return nullptr;
}

int classify_each_line(const std::string& kind, const fs::path& bundle, const fs::path& folder) {
  const model::ModelDescription model = model::read_description({bundle});
  const Work work = work_of(kind, model, model::read_bundle_weights({bundle}, model));
  if (!work) {
    fmt::print(stderr, "engine_benchmark: this build has no engine '{}'\n", kind);
    return 1;
  }
  const auto cells = static_cast<std::size_t>(model.input.width) * static_cast<std::size_t>(model.input.height);
  float sum = 0;  // keeps the compiler from removing calls
  answer_each_line([&](const std::string& line) {
    std::istringstream words(line);
    std::string group;
    std::size_t calls = 0;
    words >> group >> calls;
    const std::string text = read_text(folder / (group + ".bin"));
    std::vector<Heatmap> heatmaps;
    std::vector<std::vector<float>> inputs;
    for (std::size_t i = 0; i + cells <= text.size(); i += cells) {
      heatmaps.emplace_back(text.begin() + static_cast<std::ptrdiff_t>(i), text.begin() + static_cast<std::ptrdiff_t>(i + cells));
      inputs.emplace_back(cells);
      std::transform(heatmaps.back().begin(), heatmaps.back().end(), inputs.back().begin(),
                     [](std::uint8_t cell) { return static_cast<float>(cell) / 255.0F; });
    }
    for (std::size_t i = 0; i < heatmaps.size(); ++i) sum += work(heatmaps[i], inputs[i]);  // to fill the caches
    const double begin = wall_seconds();
    for (std::size_t i = 0; i < calls; ++i) sum += work(heatmaps[i % heatmaps.size()], inputs[i % heatmaps.size()]);
    const double us = 1e6 * (wall_seconds() - begin) / static_cast<double>(calls);
    return fmt::format("{:.4f} {:.9g}", us, work(heatmaps[0], inputs[0]));
  });
  return std::isnan(sum) ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc == 5 && argv[1] == std::string("heatmaps")) {
      write_heatmaps(argv[2], argv[3], argv[4]);
      return 0;
    }
    if (argc == 4 && argv[1] == std::string("accuracy")) {
      print_accuracies(argv[2], argv[3]);
      return 0;
    }
    if (argc == 4) return classify_each_line(argv[1], argv[2], argv[3]);
  } catch (const std::exception& e) {
    fmt::print(stderr, "engine_benchmark: {}\n", e.what());
    return 1;
  }
  fmt::print(stderr,
             "engine_benchmark: expected heatmaps DATASET MODEL FOLDER, accuracy DATASET MODEL, or ENGINE MODEL FOLDER\n");
  return 1;
}
