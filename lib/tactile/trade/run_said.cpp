#include "tactile/trade/run_said.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <mutex>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/heatmaps/run_heatmaps.hpp"
#include "tactile/model/training/train_model.hpp"

namespace tactile {
namespace {

constexpr std::size_t batch = 256;  // heatmaps rendered before they are classified together
constexpr std::size_t largest_file = std::size_t{1} << 30;

}  // namespace

RunSaid said_in_run(const std::filesystem::path& recording, const std::string& run, const Classifier& classifier,
                    microseconds tick) {
  HeatmapOptions rendering = classifier.rendering();
  rendering.tick = tick;
  RecordingReader reader(recording);
  const Stream& stream = event_stream(reader);
  const SensorSize size = stream.size ? heatmap_size(*stream.size, rendering.factor) : SensorSize{};
  if (size != classifier.input_size()) {
    throw Error(fmt::format("{}: its heatmaps are {} x {} cells; expected the {} x {} that {} was trained on", recording.string(),
                            size.width, size.height, classifier.input_size().width, classifier.input_size().height,
                            classifier.bundle().string()));
  }
  RunSaid said{.run = run, .ticks = {}, .said = {}, .events = {}};
  std::vector<std::uint8_t> waiting;
  const auto classify_waiting = [&] {
    const auto verdicts = classifier.verdicts(waiting, 1);
    said.said.insert(said.said.end(), verdicts.begin(), verdicts.end());
    waiting.clear();
  };
  said.ticks =
      for_every_tick(reader, stream.id, rendering, [&](CameraTime, std::span<const std::uint8_t> heatmap, std::uint64_t events) {
        said.events.push_back(events);
        waiting.insert(waiting.end(), heatmap.begin(), heatmap.end());
        if (waiting.size() >= batch * heatmap.size()) classify_waiting();
      });
  if (!waiting.empty()) classify_waiting();
  return said;
}

std::vector<RunSaid> said_in_runs(const Dataset& dataset, std::span<const std::uint32_t> runs, const Classifier& classifier,
                                  microseconds tick, unsigned threads, const ProgressCallback& progress) {
  std::vector<RunSaid> said(runs.size());
  std::mutex one_at_a_time;
  std::size_t done = 0;
  parallel_for(runs.size(), threads, [&](std::size_t i) {
    said[i] = said_in_run(dataset.run_folder(runs[i]) / "events.aedat4", name_of(dataset.runs()[runs[i]]), classifier, tick);
    const std::scoped_lock lock(one_at_a_time);
    tell(progress, ++done, runs.size(), fmt::format("what it says at every tick: {} of {} runs", done, runs.size()));
  });
  return said;
}

RunSaid at_tick(const RunSaid& said, microseconds tick) {
  if (tick <= microseconds{0} || tick % said.ticks.tick != microseconds{0}) {
    throw Error(fmt::format("ticks of {} us of what was said every {} us; expected a whole number of them", tick.count(),
                            said.ticks.tick.count()));
  }
  if (tick == said.ticks.tick) return said;
  RunSaid fewer{.run = said.run, .ticks = {.first = {}, .count = 0, .tick = tick}, .said = {}, .events = {}};
  for (std::int64_t i = 0; i < said.ticks.count; ++i) {
    const CameraTime t = said.ticks.at(i);
    if (us_of(t) % tick.count() != 0) continue;
    if (fewer.ticks.count++ == 0) fewer.ticks.first = t;
    fewer.said.push_back(said.said[static_cast<std::size_t>(i)]);
    fewer.events.push_back(said.events[static_cast<std::size_t>(i)]);
  }
  return fewer;
}

std::vector<Touch> verdicts_of(const RunSaid& said, std::optional<std::uint64_t> gate, const Confirmation& confirmation) {
  std::vector<Touch> verdicts = said.said;
  for (std::size_t i = 0; gate && i < verdicts.size(); ++i) {
    if (said.events[i] < *gate) verdicts[i] = Touch::none;
  }
  return confirmed(verdicts, confirmation);
}

void write_said(const std::filesystem::path& file, std::span<const RunSaid> runs) {
  nlohmann::json list = nlohmann::json::array();
  for (const RunSaid& run : runs) {
    std::string said;
    for (const Touch touch : run.said) said += static_cast<char>('0' + static_cast<int>(touch));
    list.push_back({{"run", run.run},
                    {"first_us", us_of(run.ticks.first)},
                    {"tick_us", run.ticks.tick.count()},
                    {"said", said},
                    {"events", run.events}});
  }
  write_whole(file, nlohmann::json{{"runs", list}}.dump() + "\n");
}

std::vector<RunSaid> read_said(const std::filesystem::path& file) {
  const std::string where = file.string();
  const auto json = nlohmann::json::parse(read_text(file, largest_file), nullptr, false);
  if (json.is_discarded()) throw Error(where + ": no JSON; expected what a model says in runs");
  std::vector<RunSaid> runs;
  for (const nlohmann::json& one : member<nlohmann::json>(json, "runs", where)) {
    RunSaid run;
    run.run = member<std::string>(one, "run", where);
    run.ticks.first = camera_time(member<std::int64_t>(one, "first_us", where));
    run.ticks.tick = microseconds{member<std::int64_t>(one, "tick_us", where)};
    run.events = member<std::vector<std::uint64_t>>(one, "events", where);
    for (const char digit : member<std::string>(one, "said", where)) {
      if (digit < '0' || digit > '2') throw Error(where + ": \"said\" holds another digit than 0, 1 and 2");
      run.said.push_back(static_cast<Touch>(digit - '0'));
    }
    run.ticks.count = static_cast<std::int64_t>(run.said.size());
    if (run.events.size() != run.said.size() || run.ticks.tick <= microseconds{0})
      throw Error(where + ": not one count of events for each verdict; expected what a model says in runs");
    runs.push_back(std::move(run));
  }
  return runs;
}

}  // namespace tactile
