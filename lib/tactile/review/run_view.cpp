#include "tactile/review/run_view.hpp"

#include <algorithm>
#include <filesystem>
#include <iterator>

#include "tactile/core/error.hpp"
#include "tactile/core/error_text.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/labels/label_options.hpp"
#include "tactile/review/label_cache.hpp"
#include "tactile/review/run_series.hpp"
#include "tactile/robot/robot_log.hpp"
#include "tactile/video/video_times.hpp"

namespace tactile::review {
namespace {

constexpr double share_of_robot = 0.05;   // of the time to read a run, about
constexpr std::int64_t fine_enough = 10;  // bins: a mean over so many begins and ends where it should, within a tenth

/// What decides where signals lie: the clocks.
std::string clocks_key(const labels::Labels& labels) {
  nlohmann::json key = nlohmann::json::array();
  for (const alignment::FittedClock& clock : labels.robot_clocks) key.push_back(clock.relation);
  if (labels.video_clock) key.push_back({{"video", labels.video_clock->relation}});
  return key.dump();
}

const SampledSignal* named(const std::vector<SampledSignal>* series, const std::string& name) {
  if (series == nullptr) return nullptr;
  const auto found = std::find_if(series->begin(), series->end(), [&](const SampledSignal& one) { return one.name == name; });
  return found == series->end() ? nullptr : &*found;
}

/// Nothing without labels that can be read.
std::unique_ptr<TouchedPlaces> touched_places(const RunFolder& run, const RunFacts& facts) {
  if (!is_file(run.labels()) || facts.sensor.width <= 0 || facts.sensor.height <= 0) return nullptr;
  try {
    return std::make_unique<TouchedPlaces>(facts.sensor, labels::read_labels(run.labels()), facts.first, facts.last);
  } catch (const Error&) {
    return nullptr;  // whoever asks for the labels gets the error
  }
}

std::vector<events::Event> events_in_places(std::span<const events::Event> events, const TouchedPlaces& places) {
  std::vector<events::Event> inside;
  std::copy_if(events.begin(), events.end(), std::back_inserter(inside),
               [&](const events::Event& event) { return places.contains(event); });
  return inside;
}

bool is_probability(const std::string& name) { return name.starts_with("p_"); }

}  // namespace

RunView::RunView(RunFolder run, Classify classify) : run_(std::move(run)), classify_(std::move(classify)) {
  reads_ = std::thread([this] { read(); });
}

RunView::~RunView() {
  ends_ = true;
  reads_.join();
  std::map<std::string, Prediction> predictions;
  {
    const std::scoped_lock lock(guard_);
    predictions.swap(predictions_);
  }
  for (auto& [bundle, prediction] : predictions) {
    if (prediction.thread.joinable()) prediction.thread.join();
  }
}

void RunView::check_wanted() const {
  if (ends_) throw Cancelled{};
}

void RunView::remark(std::string sentence) {
  const std::scoped_lock lock(guard_);
  remarks_.push_back(std::move(sentence));
}

void RunView::read() {
  try {
    read_robot();
    read_events();
    {
      const std::scoped_lock lock(guard_);
      state_.is_read = true;
      state_.share = 1;
    }
    if (places_) read_touched();
    if (film_pending_) read_film();
  } catch (const Cancelled&) {
  } catch (const std::exception& e) {
    const std::scoped_lock lock(guard_);
    state_.error = sentence_of(e, run_.name());
  }
}

void RunView::read_robot() {
  auto signals = std::make_shared<alignment::RunSignals>();
  signals->run = run_;
  try {
    if (std::filesystem::exists(run_.robot())) {
      nlohmann::json provenance = nlohmann::json::object();
      if (std::filesystem::exists(run_.labels())) provenance = labels::read_labels(run_.labels()).provenance;
      signals->robot = robot::read_robot_log(run_.robot(), labels::robot_log_options_of(provenance)).pieces;
    }
  } catch (const std::exception& e) {
    remark(sentence_of(e, run_.name() + "/robot.csv"));
  }
  const bool has_film = std::filesystem::exists(run_.video());
  const std::scoped_lock lock(guard_);
  signals_ = std::move(signals);
  film_pending_ = motion_pending_ = has_film;
  state_.share = share_of_robot;
}

void RunView::read_events() {
  events_ = std::make_unique<RunEvents>(run_);
  const RunFacts& facts = events_->facts();
  if (facts.has_imu) imu_ = imu_series(events_->imu(), facts.first);
  auto rate = std::make_unique<RateCounts>(facts.first, facts.last);
  std::unique_ptr<TouchedPlaces> places = touched_places(run_, facts);
  events_->for_all(
      [&](std::span<const events::Event> events) {
        rate->add(events);
        if (places) places->add(events);
      },
      [&](double share) {
        check_wanted();
        const std::scoped_lock lock(guard_);
        state_.share = share_of_robot + (1 - share_of_robot) * share;
      });
  rate->finish();
  rate_ = std::move(rate);
  if (places) places->choose();
  if (places && !places->empty()) places_ = std::move(places);
}

void RunView::read_touched() {
  const RunFacts& facts = events_->facts();
  auto touched = std::make_shared<RateCounts>(facts.first, facts.last);
  events_->for_all([&](std::span<const events::Event> events) { touched->add(events_in_places(events, *places_)); },
                   [&](double) { check_wanted(); });
  touched->finish();
  const std::scoped_lock lock(guard_);
  touched_ = std::move(touched);
}

void RunView::read_film() {
  const auto advance = [this] { check_wanted(); };
  const auto none_pending = [this] {
    const std::scoped_lock lock(guard_);
    film_pending_ = motion_pending_ = false;
  };
  try {
    auto film = std::make_shared<const FilmFrames>(run_, advance);
    {
      const std::scoped_lock lock(guard_);
      film_ = std::move(film);
      film_pending_ = false;
    }
    const std::vector<VideoTime> rows =
        std::filesystem::exists(run_.video_times()) ? video::read_video_times(run_.video_times()) : std::vector<VideoTime>();
    alignment::MotionEnergyOptions options;
    if (std::filesystem::exists(run_.labels()))
      options = labels::signals_options_of(labels::read_labels(run_.labels()).provenance).video;
    auto energy = alignment::motion_energy(run_.video(), rows, options, advance);
    const std::scoped_lock lock(guard_);
    auto signals = std::make_shared<alignment::RunSignals>(*signals_);
    signals->video = std::move(energy);
    signals_ = std::move(signals);
    motion_pending_ = false;
  } catch (const Cancelled&) {
    throw;
  } catch (const std::exception& e) {
    none_pending();
    remark("the film cannot be shown: " + sentence_of(e, run_.name() + "/video.mp4"));
  }
}

RunView::State RunView::state() const {
  const std::scoped_lock lock(guard_);
  return state_;
}

std::shared_ptr<const FilmFrames> RunView::film() const {
  const std::scoped_lock lock(guard_);
  return film_;
}

bool RunView::film_is_pending() const {
  const std::scoped_lock lock(guard_);
  return film_pending_;
}

std::vector<std::string> RunView::remarks() const {
  const std::scoped_lock lock(guard_);
  return remarks_;
}

std::shared_ptr<const RunView::AllSeries> RunView::placed(const labels::Labels& labels) const {
  const std::scoped_lock lock(guard_);
  const std::string key = clocks_key(labels) + (signals_->video ? " film" : "");
  if (placed_by_ != key) {
    placed_ = std::make_shared<const AllSeries>(placed_series(*signals_, labels, events_->facts().first));
    placed_by_ = key;
  }
  return placed_;
}

nlohmann::json RunView::signals(const labels::Labels* labels) const {
  nlohmann::json list = nlohmann::json::array();
  const auto add = [&](const std::string& name, const std::string& unit, const std::string& label) {
    list.push_back({{"name", name}, {"unit", unit}, {"label", label}});
  };
  add("event_rate", "events/ms", "Event rate");
  if (places_) add("touched_rate", "events/ms", "Event rate of the touched places");
  bool has_motion = false;
  if (labels != nullptr) {
    for (const SampledSignal& signal : *placed(*labels)) {
      add(signal.name, signal.unit, signal.label);
      has_motion = has_motion || signal.name == "film_motion";
    }
  }
  const std::scoped_lock lock(guard_);
  if (!has_motion && motion_pending_ && labels != nullptr && labels->video_clock)
    add("film_motion", "grey levels/s", "Motion in the film");
  if (!imu_.t_us.empty()) add(imu_.name, imu_.unit, imu_.label);
  return list;
}

std::shared_ptr<const RateCounts> RunView::touched_counts() const {
  const std::scoped_lock lock(guard_);
  return touched_;
}

SignalWindow RunView::rate_window(const RateCounts& counts, const TouchedPlaces* places, const WindowRequest& request) const {
  const std::int64_t bucket = request.bucket_us(1), over = std::max(bucket, request.smooth_us);
  const microseconds length{request.to_us - request.from_us};
  if (length > longest_exact || over >= fine_enough * counts.bin().count()) return counts.window(request);
  // Of this part alone in bins of 1 us. It begins at a whole multiple of the buckets, so that they stay where they are.
  const RunFacts& facts = events_->facts();
  const std::int64_t margin = over + bucket, skipped = std::max<std::int64_t>(0, (request.from_us - margin) / bucket * bucket);
  const CameraTime begin = after(facts.first, microseconds{skipped});
  const CameraTime end = std::min(after(facts.first, microseconds{request.to_us + margin}), after(facts.last, 1us));
  if (end <= begin) return counts.window(request);
  const auto events = events_->events_in(begin, end, most_exact_events);
  if (!events) return counts.window(request);
  RateCounts fine(begin, before(end, 1us), 1us);
  fine.add(places != nullptr ? events_in_places(*events, *places) : *events);
  fine.finish();
  SignalWindow window = fine.window({.from_us = request.from_us - skipped,
                                     .to_us = request.to_us - skipped,
                                     .points = request.points,
                                     .smooth_us = request.smooth_us});
  for (std::int64_t& t : window.t_us) t += skipped;
  return window;
}

nlohmann::json RunView::windows(const std::vector<std::string>& names, const WindowRequest& request, const labels::Labels* labels,
                                const std::filesystem::path& bundle) {
  const std::shared_ptr<const AllSeries> own = labels != nullptr ? placed(*labels) : nullptr;
  nlohmann::json series = nlohmann::json::object(), pending = nlohmann::json::array();
  for (const std::string& name : names) {
    if (name == "event_rate") {
      series[name] = json_of(rate_window(*rate_, nullptr, request));
    } else if (name == "touched_rate" && places_) {
      const std::shared_ptr<const RateCounts> touched = touched_counts();
      if (touched) {
        series[name] = json_of(rate_window(*touched, places_.get(), request));
      } else {
        pending.push_back(name);
      }
    } else if (name == imu_.name && !imu_.t_us.empty()) {
      series[name] = json_of(window_of(imu_, request));
    } else if (is_probability(name)) {
      if (bundle.empty()) continue;
      const std::shared_ptr<const AllSeries> all = predicted(bundle);
      if (all == nullptr) {
        pending.push_back(name);
      } else if (const SampledSignal* signal = named(all.get(), name)) {
        series[name] = json_of(window_of(*signal, request));
      }
    } else if (const SampledSignal* signal = named(own.get(), name)) {
      series[name] = json_of(window_of(*signal, request));
    } else if (name == "film_motion") {
      const std::scoped_lock lock(guard_);
      if (motion_pending_) pending.push_back(name);
    }
  }
  return {{"from_us", request.from_us}, {"to_us", request.to_us}, {"series", std::move(series)}, {"pending", std::move(pending)}};
}

std::shared_ptr<const RunView::AllSeries> RunView::predicted(const std::filesystem::path& bundle) {
  const std::string key = bundle.string(), stamp = stamp_of(bundle / "model.json");
  std::vector<std::thread> outdated;
  {
    const std::scoped_lock lock(guard_);
    const auto found = predictions_.find(key);
    if (found != predictions_.end() && found->second.stamp == stamp) return found->second.series;
    const auto forget = [&](const auto& entry) {
      *entry->second.is_wanted = false;
      outdated.push_back(std::move(entry->second.thread));
      predictions_.erase(entry);
    };
    if (found != predictions_.end()) forget(found);
    while (predictions_.size() >= most_models) {
      const auto done = std::find_if(predictions_.begin(), predictions_.end(),
                                     [](const auto& entry) { return entry.second.series != nullptr; });
      if (done == predictions_.end()) break;
      forget(done);
    }
    Prediction& prediction = predictions_[key];
    prediction.stamp = stamp;
    prediction.thread = std::thread([this, bundle, is_wanted = prediction.is_wanted] { predict(bundle, *is_wanted); });
  }
  for (std::thread& thread : outdated) thread.join();
  return nullptr;
}

void RunView::predict(const std::filesystem::path& bundle, const std::atomic<bool>& is_wanted) {
  auto series = std::make_shared<AllSeries>();
  try {
    const std::scoped_lock one_at_a_time(predicting_);
    const auto check = [&](std::size_t) {
      if (!is_wanted) throw Cancelled{};
      check_wanted();
    };
    check(0);
    for (SampledSignal& signal : probability_series(classify_(run_.events(), bundle, check), events_->facts().first))
      series->push_back(std::move(signal));
  } catch (const Cancelled&) {
    return;
  } catch (const std::exception& e) {
    remark("the probabilities of " + bundle.filename().string() + " cannot be shown: " + sentence_of(e));
  }
  const std::scoped_lock lock(guard_);
  if (const auto found = predictions_.find(bundle.string()); is_wanted && found != predictions_.end())
    found->second.series = std::move(series);
}

}  // namespace tactile::review
