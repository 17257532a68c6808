#include "tactile/experiments/trade/tick_times.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <numeric>
#include <tuple>

#include "tactile/core/error.hpp"
#include "tactile/core/error_text.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/random.hpp"
#include "tactile/core/robust_statistics.hpp"
#include "tactile/core/ticks.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/experiments/file_step.hpp"
#include "tactile/model/bundle/model_bundle.hpp"
#include "tactile/model/training/open_classifier.hpp"

namespace tactile::trade {
namespace {

using Clock = std::chrono::steady_clock;
using Network = std::function<model::Logits(std::span<const std::uint8_t>)>;

constexpr std::int64_t warm_up_ticks = 1;

/// Networks, each opened once: several settings may share one.
class Networks {
 public:
  Network of(const TimedSetting& setting) {
    const auto key = std::tuple(setting.model, setting.engine, setting.precision, setting.sparse);
    const auto found = networks_.find(key);
    return found != networks_.end() ? found->second : networks_[key] = opened(setting);
  }

 private:
  static Network opened(const TimedSetting& setting) {
    if (setting.engine == model::EngineKind::libtorch) {
      const auto classifier =
          std::make_shared<model::Classifier>(model::open_classifier(setting.model, 1, model::EngineKind::libtorch));
      return [classifier](std::span<const std::uint8_t> heatmap) { return classifier->classify(heatmap, 1).front(); };
    }
    const model::ModelBundle bundle{setting.model};
    const model::ModelDescription description = model::read_description(bundle);
    const auto engine = std::make_shared<model::LeNetEngine>(
        description.input, model::read_bundle_weights(bundle, description), description.settings.network,
        model::EngineOptions{.precision = setting.precision, .skip_empty = setting.sparse});
    return [engine](std::span<const std::uint8_t> heatmap) { return engine->classify(heatmap); };
  }

  std::map<std::tuple<std::filesystem::path, model::EngineKind, model::Precision, bool>, Network> networks_;
};

struct Recorded {
  std::vector<events::Event> events;
  events::SensorSize sensor;

  std::span<const events::Event> between(CameraTime begin, CameraTime end) const {
    const auto place = [&](CameraTime t) {
      return std::lower_bound(events.begin(), events.end(), t,
                              [](const events::Event& event, CameraTime time) { return event.t < time; });
    };
    return {place(begin), place(end)};
  }
};

Recorded events_of(const std::filesystem::path& recording) {
  events::RecordingReader reader(recording);
  const events::Stream& stream = events::event_stream(reader);
  Recorded recorded;
  recorded.sensor = stream.size.value_or(events::SensorSize{});
  events::for_all_events(reader, stream.id, [&](std::span<const events::Event> events) {
    recorded.events.insert(recorded.events.end(), events.begin(), events.end());
  });
  if (recorded.events.empty()) throw Error(recording.string() + ": no events; expected some to time detection with");
  return recorded;
}

/// The measured ticks of a piece.
struct Piece {
  CameraTime first{};
  std::int64_t ticks = 0;
};

Piece piece_of(const TickRange& all, unsigned piece, const TickTimesOptions& options) {
  const std::int64_t ticks = std::min<std::int64_t>(options.ticks, all.count);
  const double middle = (piece + 0.5) / options.pieces * static_cast<double>(all.count);
  const auto begin = static_cast<std::int64_t>(middle) - ticks / 2;
  return {all.at(std::clamp<std::int64_t>(begin, 0, all.count - ticks)), ticks};
}

/// One turn of one setting over a piece.
void take_turn(const TimedSetting& setting, const Network& network, const Recorded& recorded, const Piece& piece,
               std::span<std::vector<TickTime>> turns) {
  const heatmaps::HeatmapOptions& options = setting.rendering;
  heatmaps::HeatmapRenderer renderer(recorded.sensor, options);
  std::vector<std::uint8_t> heatmap(static_cast<std::size_t>(renderer.size().width) *
                                    static_cast<std::size_t>(renderer.size().height));
  CameraTime given = before(piece.first, options.history + options.tick * warm_up_ticks);
  for (std::int64_t i = -warm_up_ticks; i < piece.ticks; ++i) {
    const CameraTime t = after(piece.first, options.tick * i);
    const std::span<const events::Event> events = recorded.between(given, t);
    given = t;
    const auto begin = Clock::now();
    renderer.add(events);
    renderer.move_to(t);
    const auto counted = Clock::now();
    renderer.render(std::span(heatmap));
    const auto rendered = Clock::now();
    network(heatmap);
    const auto end = Clock::now();
    if (i < 0) continue;
    turns[static_cast<std::size_t>(i)].push_back(
        {us_between(begin, counted), us_between(counted, rendered), us_between(rendered, end), renderer.events()});
  }
}

/// Each turn has another order, because a setting finds in the caches what the one before it left, such as the same weights.
std::vector<std::size_t> any_order(std::size_t count, Random& random) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  random.shuffle(order);
  return order;
}

TickTime median_of(const std::vector<TickTime>& turns) {
  return value_of_rank<TickTime>(turns, (turns.size() - 1) / 2,
                                 [](const TickTime& a, const TickTime& b) { return a.total({}) < b.total({}); });
}

}  // namespace

std::vector<TimesOfRuns> time_ticks(std::span<const TimedSetting> settings, std::span<const std::filesystem::path> recordings,
                                    const TickTimesOptions& options, const ProgressCallback& progress) {
  Random random(1);
  Networks networks;
  std::vector<Network> network_of;
  for (const TimedSetting& setting : settings) network_of.push_back(networks.of(setting));
  std::vector<TimesOfRuns> times(settings.size(), TimesOfRuns(recordings.size()));
  std::uint64_t done = 0;
  for (std::size_t run = 0; run < recordings.size(); ++run) {
    const Recorded recorded = events_of(recordings[run]);
    const CameraTime first = recorded.events.front().t, last = recorded.events.back().t;
    for (unsigned piece_index = 0; piece_index < options.pieces; ++piece_index) {
      std::vector<Piece> pieces;
      std::vector<std::vector<std::vector<TickTime>>> turns;  // of each setting, of each tick
      for (const TimedSetting& setting : settings) {
        const TickRange all = full_ticks(first, last, setting.rendering.history, setting.rendering.tick);
        pieces.push_back(all.count > 0 ? piece_of(all, piece_index, options) : Piece{});
        turns.emplace_back(static_cast<std::size_t>(pieces.back().ticks));
      }
      for (unsigned turn = 0; turn < options.turns; ++turn) {
        for (const std::size_t i : any_order(settings.size(), random)) {
          if (pieces[i].ticks > 0) take_turn(settings[i], network_of[i], recorded, pieces[i], turns[i]);
        }
        tell(progress, ++done, std::uint64_t{recordings.size()} * options.pieces * options.turns,
             fmt::format("times of {} settings, in turns", settings.size()));
      }
      for (std::size_t i = 0; i < settings.size(); ++i) {
        for (const std::vector<TickTime>& tick : turns[i]) times[i][run].push_back(median_of(tick));
      }
    }
  }
  return times;
}

void write_times(const std::filesystem::path& file, std::span<const TimesOfRuns> times) {
  nlohmann::json list = nlohmann::json::array();
  for (const TimesOfRuns& of_setting : times) {
    nlohmann::json runs = nlohmann::json::array();
    for (const auto& run : of_setting) {
      nlohmann::json ticks = nlohmann::json::array();
      for (const TickTime& tick : run)
        ticks.push_back(nlohmann::json::array({tick.counting, tick.rendering, tick.network, tick.events}));
      runs.push_back(std::move(ticks));
    }
    list.push_back(std::move(runs));
  }
  write_whole(file, nlohmann::json{{"ways", list}}.dump() + "\n");
}

std::vector<TimesOfRuns> read_times(const std::filesystem::path& file) {
  const auto json = nlohmann::json::parse(read_text(file, experiments::largest_step_file), nullptr, false);
  try {
    std::vector<TimesOfRuns> times;
    for (const auto& runs : json.at("ways")) {
      times.emplace_back();
      for (const auto& run : runs) {
        times.back().emplace_back();
        for (const auto& tick : run) {
          times.back().back().push_back(
              {tick.at(0).get<float>(), tick.at(1).get<float>(), tick.at(2).get<float>(), tick.at(3).get<std::uint64_t>()});
        }
      }
    }
    return times;
  } catch (const nlohmann::json::exception& e) {
    throw Error(fmt::format("{}: {}; expected times of ticks", file.string(), "a value " + plain_words(e.what())));
  }
}

}  // namespace tactile::trade
