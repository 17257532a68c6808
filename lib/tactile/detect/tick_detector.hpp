#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <span>

#include "tactile/heatmaps/heatmap_renderer.hpp"
#include "tactile/model/inference/decision.hpp"
#include "tactile/model/inference/event_classifier.hpp"
#include "tactile/model/inference/logits.hpp"

namespace tactile::detect {

/// The verdict at one tick, and what led to it.
struct TickVerdict {
  CameraTime t{};
  std::uint64_t events = 0;                     ///< in [t_c - t_h, t_c)
  model::Probabilities probabilities{1, 0, 0};  ///< of none, press, slip
  Touch predicted = Touch::none;                ///< by the model at this tick, before the decision
  Touch verdict = Touch::none;                  ///< after the decision
  bool slip_is_confirmed = false;               ///< the verdict is a slip that is hardly a firm lift
};

/// The computing time of one tick.
struct TickCost {
  std::chrono::nanoseconds rendering{0};  ///< moving the window, and the model's input, such as a heatmap
  std::chrono::nanoseconds network{0};    ///< with the decision
};

struct TickDetectorOptions {
  heatmaps::HeatmapOptions rendering;  ///< of a model without heatmaps, history, tick and mask
  model::Decision decision{};
  double temperature = 1;  ///< of the probabilities, > 0
};

/// Verdicts from events, tick by tick, with the model and decision of `eval`: the same events give the same verdicts.
/// Allocates memory only for a history with more events than any before.
class TickDetector {
 public:
  /// @param model  made for the options' rendering
  TickDetector(std::unique_ptr<model::EventClassifier> model, const TickDetectorOptions& options);

  void add(std::span<const events::Event> events) { model_->add(events); }  ///< @throws Error as EventClassifier

  /// Counts the events so far of the history that ends at `t`, and forgets earlier ones. This leaves less work for the verdict at
  /// `t` or a later tick, and changes no verdict.
  void count_ahead(CameraTime t) { model_->move_to(t); }

  /// Makes the input and runs the model without use, so that weights and code are in the cache for the next verdict. Changes no
  /// verdict.
  void rehearse();

  /// The verdict at the tick `t`, which is later than the last one. Skipped ticks in between count as none.
  TickVerdict verdict_at(CameraTime t, std::uint64_t skipped, TickCost& cost);

  /// Forgets all events and verdicts: the next events may have any time.
  void restart();

 private:
  double temperature_;
  std::unique_ptr<model::EventClassifier> model_;
  model::RunningDecision decision_;
};

}  // namespace tactile::detect
