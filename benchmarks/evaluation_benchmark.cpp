// Measures the evaluation of a full run at every tick, and its lower limit: the network alone on the same heatmaps in batches.
// `scripts/bench --evaluation` runs it.
//
//   evaluation_benchmark FOLDER RECORDING…    writes an untrained model to FOLDER; prints a table in Markdown
//
// All steps are measured in turn on one thread, in several rounds, by CPU time. A ratio is the median of the ratios of the
// rounds.

#include <fmt/core.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "measured_time.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/robust_statistics.hpp"
#include "tactile/evaluation/full_run.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/heatmaps/run_heatmaps.hpp"
#include "tactile/model/bundle/model_bundle.hpp"
#include "tactile/model/training/lenet.hpp"

namespace tactile::bench {
namespace {

constexpr int rounds = 9;
constexpr std::size_t batch = 256, most_heatmaps = 20'000;

double seconds_of(const std::function<void()>& work) {
  const double before = cpu_seconds();
  work();
  return cpu_seconds() - before;
}

events::SensorSize sensor_of(const std::filesystem::path& recording) {
  const events::RecordingReader reader(recording);
  const auto size = events::event_stream(reader).size;
  if (!size) throw Error(recording.string() + ": the event stream has no sensor size");
  return *size;
}

void measure(const std::filesystem::path& folder, const std::filesystem::path& recording) {
  model::ModelDescription description;
  description.input = heatmaps::heatmap_size(sensor_of(recording), description.settings.rendering.factor);
  const model::ModelBundle bundle{folder / "model"};
  model::write_bundle(bundle, description, {model::LeNet(description.input, std::uint64_t{1}).weights(), {}}, {});
  const model::Classifier classifier(bundle.folder, 1);

  std::vector<std::uint8_t> heatmaps;
  std::size_t ticks = 0;
  const auto render = [&](const heatmaps::TickCallback& use) {
    events::RecordingReader reader(recording);
    heatmaps::for_every_tick(reader, events::event_stream(reader).id, classifier.rendering(), use);
  };
  render([&](CameraTime, std::span<const std::uint8_t> heatmap, std::uint64_t) {
    ++ticks;
    if (ticks <= most_heatmaps) heatmaps.insert(heatmaps.end(), heatmap.begin(), heatmap.end());
  });
  if (ticks == 0 || ticks > most_heatmaps)
    throw Error(fmt::format("{}: {} ticks; expected 1 to {}", recording.string(), ticks, most_heatmaps));
  const std::size_t cells = heatmaps.size() / ticks;

  std::vector<double> network, whole, rendering, reading, ratio, share;
  for (int round = 0; round < rounds; ++round) {
    network.push_back(seconds_of([&] {
      for (std::size_t first = 0; first < ticks; first += batch)
        classifier.classify(std::span(heatmaps).subspan(first * cells, std::min(batch, ticks - first) * cells), 1);
    }));
    whole.push_back(seconds_of([&] { evaluation::classify_full_run(recording, classifier); }));
    rendering.push_back(seconds_of([&] { render([](CameraTime, std::span<const std::uint8_t>, std::uint64_t) {}); }));
    reading.push_back(seconds_of([&] {
      events::RecordingReader reader(recording);
      events::for_all_events(reader, events::event_stream(reader).id, [](std::span<const events::Event>) {});
    }));
    ratio.push_back(whole.back() / network.back());
    share.push_back(rendering.back() / whole.back());
  }
  const auto us_a_tick = [&](const std::vector<double>& seconds) { return 1e6 * median(seconds) / static_cast<double>(ticks); };
  fmt::print("| {} | {} | {:.0f} | {:.0f} | **{:.2f}** | {:.1f} | {:.1f} | **{:.1f} %** |\n",
             recording.parent_path().parent_path().filename().string() + "/" + recording.parent_path().filename().string(), ticks,
             us_a_tick(whole), us_a_tick(network), median(ratio), us_a_tick(rendering), us_a_tick(reading), 100 * median(share));
}

}  // namespace
}  // namespace tactile::bench

int main(int argc, char** argv) {
  if (argc < 3) {
    fmt::print(stderr, "evaluation_benchmark: expected FOLDER RECORDING…\n");
    return 1;
  }
  try {
    fmt::print(
        "| run | ticks | evaluation | network alone | ratio | rendering, reading included | reading | share of rendering |\n");
    fmt::print("| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n");
    for (int i = 2; i < argc; ++i) tactile::bench::measure(argv[1], argv[i]);
  } catch (const std::exception& e) {
    fmt::print(stderr, "error: {}\n", e.what());
    return 1;
  }
  return 0;
}
