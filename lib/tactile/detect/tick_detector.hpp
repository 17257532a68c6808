#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "tactile/evaluation/confirmation.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/model/inference/logits.hpp"

namespace tactile {

/// The logits of one heatmap of the network's input size. Whatever runs the network: it keeps its own working memory.
using ClassifyHeatmap = std::function<Logits(std::span<const std::uint8_t> heatmap)>;

/// What is said at one tick.
struct TickVerdict {
  CameraTime t{};
  std::uint64_t events = 0;              ///< in [t_c - t_h, t_c)
  Probabilities probabilities{1, 0, 0};  ///< of none, press, slip; as here where the gate spared the network
  Touch said = Touch::none;              ///< by gate or network, at this tick
  Touch verdict = Touch::none;           ///< said, confirmed
  bool gated = false;                    ///< fewer events than the gate's limit: none, without rendering or network
};

/// What one tick took.
struct TickCost {
  std::chrono::nanoseconds rendering{0};  ///< the window moved on, and the heatmap
  std::chrono::nanoseconds network{0};    ///< confirmation included
};

struct TickDetectorOptions {
  HeatmapOptions rendering;
  Confirmation confirmation{};
  std::optional<std::uint64_t> gate = std::nullopt;  ///< least number of events in t_h that the network is asked about
};

/// Verdicts from events, tick by tick: the renderer, the gate, the network and the confirmation that `eval` has, so that the same
/// events give the same verdicts. Asks for no memory but for a history with more events than ever before.
class TickDetector {
 public:
  /// @param input  the network's
  /// @throws Error  if this sensor's heatmaps are of another size, or as HeatmapRenderer
  TickDetector(SensorSize sensor, SensorSize input, ClassifyHeatmap classify, const TickDetectorOptions& options);

  void add(std::span<const Event> events) { renderer_.add(events); }  ///< @throws Error as HeatmapRenderer

  /// Counts what is here of the history that ends at `t`, and forgets what lies before it, ahead of the verdict at `t` or a later
  /// tick, which then has the less to do. It changes no verdict.
  void count_ahead(CameraTime t) { renderer_.move_to(t); }

  /// Renders what is counted and asks the network about it, for nothing but that weights and code are in the cache when a verdict
  /// is wanted. It changes no verdict. @return  false where the gate would spare the network
  bool rehearse();

  /// The verdict at the tick `t`, which lies behind the last one. Ticks that were skipped in between count as none.
  TickVerdict verdict_at(CameraTime t, std::uint64_t skipped, TickCost& cost);

  /// Forgets all events and verdicts: what comes next may lie at any time.
  void restart();

 private:
  SensorSize sensor_;
  TickDetectorOptions options_;
  ClassifyHeatmap classify_;
  HeatmapRenderer renderer_;
  RunningConfirmation confirmation_;
  std::vector<std::uint8_t> heatmap_;
};

}  // namespace tactile
