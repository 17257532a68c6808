#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "tactile/alignment/run_signals.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/labels/labels.hpp"
#include "tactile/results/full_run.hpp"
#include "tactile/review/film_frames.hpp"
#include "tactile/review/rate_counts.hpp"
#include "tactile/review/run_events.hpp"
#include "tactile/review/signal_window.hpp"
#include "tactile/review/touched_places.hpp"

namespace tactile::review {

/// The probabilities of a model at every tick of a recording, as `tactile eval --run` computes them. `advance` may throw to end
/// it.
using Classify = std::function<results::FullRun(const std::filesystem::path& recording, const std::filesystem::path& bundle,
                                                const std::function<void(std::size_t ticks)>& advance)>;

/// An open run: what the page shows of it. Its events are counted, and its robot log and its film are read, on a thread of its
/// own; windows of events are read when they are asked for. Memory follows the length of the run, not its events. All functions
/// may be called from several threads.
class RunView {
 public:
  RunView(RunFolder run, Classify classify);
  ~RunView();  ///< ends what is being read

  const RunFolder& run() const { return run_; }

  struct State {
    bool is_read = false;  ///< the events are counted, and the robot log is read; the film may still be
    double share = 0;      ///< of the reading, in [0, 1]
    std::string error;     ///< why it cannot be shown; empty if it can
  };
  State state() const;

  // Once it is read:
  const RunEvents& events() const { return *events_; }

  /// [{"name", "unit", "label"}] of the signals that the run has, without those of models; of the film also while it is decoded.
  nlohmann::json signals(const labels::Labels* labels) const;

  /// {"series": {name: window}, "pending": [names]} of the signals `names` that the run has.
  /// @param labels  whose clocks place robot and film; nothing: there are none
  /// @param bundle  of the model that p_none, p_press and p_slip come from; empty: none is asked for
  nlohmann::json windows(const std::vector<std::string>& names, const WindowRequest& request, const labels::Labels* labels,
                         const std::filesystem::path& bundle);

  /// The film; nothing while it is decoded, and without one.
  std::shared_ptr<const FilmFrames> film() const;
  bool film_is_pending() const;

  std::vector<std::string> remarks() const;  ///< sentences: what cannot be shown, and why

  static constexpr microseconds longest_exact{200'000};        ///< a longer window is of whole bins
  static constexpr std::size_t most_exact_events = 2'000'000;  ///< of a window; with more, it is of whole bins
  static constexpr std::size_t most_models = 8;                ///< whose probabilities are kept

 private:
  using AllSeries = std::vector<SampledSignal>;

  void read();
  void read_events();
  void read_touched();
  void read_robot();
  void read_film();
  void predict(const std::filesystem::path& bundle, const std::atomic<bool>& is_wanted);
  void check_wanted() const;
  void remark(std::string sentence);
  std::shared_ptr<const AllSeries> placed(const labels::Labels& labels) const;
  std::shared_ptr<const AllSeries> predicted(const std::filesystem::path& bundle);
  std::shared_ptr<const RateCounts> touched_counts() const;
  SignalWindow rate_window(const RateCounts& counts, const TouchedPlaces* places, const WindowRequest& request) const;

  RunFolder run_;
  Classify classify_;
  std::atomic<bool> ends_{false};
  std::unique_ptr<RunEvents> events_;
  std::unique_ptr<const RateCounts> rate_;
  std::unique_ptr<TouchedPlaces> places_;  ///< nothing if the labels show none
  SampledSignal imu_;

  mutable std::mutex guard_;  ///< of all below
  State state_;
  std::vector<std::string> remarks_;
  std::shared_ptr<const RateCounts> touched_;             ///< of `places_`; nothing while it is counted
  std::shared_ptr<const alignment::RunSignals> signals_;  ///< robot, and the film's motion once it is decoded
  bool film_pending_ = false, motion_pending_ = false;
  std::shared_ptr<const FilmFrames> film_;
  mutable std::string placed_by_;  ///< the clocks, and what was read, that `placed_` is of
  mutable std::shared_ptr<const AllSeries> placed_;
  struct Prediction {
    std::string stamp;                        ///< of the bundle's model.json
    std::shared_ptr<const AllSeries> series;  ///< nothing while it is computed, and if it failed
    std::shared_ptr<std::atomic<bool>> is_wanted = std::make_shared<std::atomic<bool>>(true);
    std::thread thread{};
  };
  std::map<std::string, Prediction> predictions_;  ///< by the bundle's folder
  std::mutex predicting_;                          ///< one model at a time

  std::thread reads_;
};

}  // namespace tactile::review
