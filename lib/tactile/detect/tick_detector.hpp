#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/model/inference/background_ratio.hpp"
#include "tactile/model/inference/decision.hpp"
#include "tactile/model/inference/event_classifier.hpp"
#include "tactile/model/inference/logits.hpp"

namespace tactile::detect {

/// The verdict at one tick, and what led to it.
struct TickVerdict {
  CameraTime t{};
  std::uint64_t events = 0;                     ///< in [t_c - t_h, t_c)
  model::Probabilities probabilities{1, 0, 0};  ///< of none, press, slip; {1, 0, 0} if gated
  Touch predicted = Touch::none;                ///< by gate or network at this tick, before confirmation or filter
  Touch verdict = Touch::none;                  ///< after confirmation or filter
  bool gated = false;                           ///< the gate is closed: none, without rendering or network
};

/// The computing time of one tick.
struct TickCost {
  std::chrono::nanoseconds rendering{0};  ///< moving the window, and the model's input: a heatmap, or features
  std::chrono::nanoseconds network{0};    ///< with confirmation or filter
};

struct TickDetectorOptions {
  heatmaps::HeatmapOptions rendering;  ///< of a model without heatmaps, history, tick and mask
  model::Decision decision{};
  std::optional<model::GateRule> gate = std::nullopt;  ///< when the network does not run
  double temperature = 1;                              ///< of the probabilities, > 0
};

/// Verdicts from events, tick by tick, with the model, gate and decision of `eval`: the same events give the same verdicts.
/// Allocates memory only for a history with more events than any before.
class TickDetector {
 public:
  /// @param model  made for this sensor and the options' rendering
  TickDetector(events::SensorSize sensor, std::unique_ptr<model::EventClassifier> model, const TickDetectorOptions& options);

  void add(std::span<const events::Event> events) {  ///< @throws Error as EventClassifier
    model_->add(events);
    if (ratio_) ratio_->add(events);
  }

  /// Counts the events so far of the history that ends at `t`, and forgets earlier ones. This leaves less work for the verdict at
  /// `t` or a later tick, and changes no verdict.
  void count_ahead(CameraTime t) { model_->move_to(t); }

  /// Makes the input and runs the model without use, so that weights and code are in the cache for the next verdict. Changes no
  /// verdict.
  /// @return  false, and nothing is done, if the gate was closed at the last verdict, or the events are fewer than its limit
  bool rehearse();

  /// The verdict at the tick `t`, which is later than the last one. Skipped ticks in between count as none.
  TickVerdict verdict_at(CameraTime t, std::uint64_t skipped, TickCost& cost);

  /// Forgets all events and verdicts: the next events may have any time.
  void restart();

 private:
  void begin_ratio();

  events::SensorSize sensor_;
  TickDetectorOptions options_;
  std::unique_ptr<model::EventClassifier> model_;
  std::optional<model::BackgroundRatio> ratio_;  ///< with a gate that compares with the background
  bool gated_ = false;                           ///< at the last verdict
  model::RunningDecision decision_;
};

}  // namespace tactile::detect
