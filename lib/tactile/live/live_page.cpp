#include "tactile/live/live_page.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <deque>
#include <limits>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "tactile/core/json_text.hpp"
#include "tactile/live/live_pictures.hpp"
#include "tactile/live/minute.hpp"

namespace tactile::live {
namespace {

using Steady = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds step{50};
constexpr std::size_t steps_per_second = 20;

double seconds(Steady::duration duration) { return std::chrono::duration<double>(duration).count(); }

/// How many events came in the last second, by their number at the start of each step.
class RateMeter {
 public:
  struct Rates {
    double of_step = 0, of_second = 0;  ///< [events/s]
  };

  Rates next(std::uint64_t events, Steady::time_point now) {
    counts_.emplace_back(events, now);
    if (counts_.size() > steps_per_second + 1) counts_.pop_front();
    if (counts_.size() < 2) return {};
    return {.of_step = between(counts_[counts_.size() - 2]), .of_second = between(counts_.front())};
  }

 private:
  using Count = std::pair<std::uint64_t, Steady::time_point>;
  double between(const Count& from) const {
    const double passed = seconds(counts_.back().second - from.second);
    return passed > 0 ? static_cast<double>(counts_.back().first - from.first) / passed : 0.0;
  }

  std::deque<Count> counts_;
};

review::PageResponse chosen(const review::PageRequest& request, const LivePageOptions& options) {
  const nlohmann::json json = review::json_in(request);
  const auto question = json.find("question"), choice = json.find("choice");
  const bool is_complete =
      question != json.end() && choice != json.end() && question->is_number_unsigned() && choice->is_string();
  if (!is_complete) throw review::Refusal(400, "no choice; expected {\"question\": number, \"choice\": name}");
  if (!options.choose(*question, *choice)) throw review::Refusal(409, "this was no longer asked, so nothing was done");
  return review::json_response({{"chosen", *choice}});
}

}  // namespace

struct LivePage::State {
  explicit State(LivePageOptions given)
      : options(std::move(given)),
        watch(options.rendering.history),
        pictures(watch, options.sensor, options.rendering),
        noted(options.values.size(), none),
        thread([this] { run(); }) {}

  static constexpr double none = std::numeric_limits<double>::quiet_NaN();

  LivePageOptions options;
  EventWatch watch;
  LivePictures pictures;  ///< of the page's thread
  std::atomic<int> viewers{0};

  std::mutex inbox;  ///< held for an exchange only: of the next two
  std::shared_ptr<const nlohmann::json> newest_state;
  std::vector<double> noted;

  std::mutex guard;  ///< of all that follows; what is watched does not take it
  std::condition_variable changed;
  std::shared_ptr<const nlohmann::json> shown = std::make_shared<const nlohmann::json>();
  LivePicture picture;
  double rate = 0, silent_s = 0;
  Minute minute;
  std::uint64_t number = 0;  ///< of the state that is shown
  bool ends = false, has_ended = false;

  std::thread thread;

  void run();
  nlohmann::json live() const;
  std::optional<std::string> part(std::uint64_t& seen, std::uint64_t& next_step);
};

/// The page's own thread.
void LivePage::State::run() {
  RateMeter meter;
  const Steady::time_point begun = Steady::now();
  Steady::time_point next = begun, last_event = begun;
  std::uint64_t events_before = 0;
  std::unique_lock lock(guard);
  while (!has_ended) {
    lock.unlock();
    const Steady::time_point now = Steady::now();
    const std::uint64_t events = watch.events();
    if (events != std::exchange(events_before, events)) last_event = now;
    if (viewers > 0) pictures.look(now);
    std::shared_ptr<const nlohmann::json> state;
    std::vector<double> values(options.values.size(), none);
    {
      const std::scoped_lock exchange(inbox);
      state = newest_state;
      values.swap(noted);
    }
    const RateMeter::Rates rates = meter.next(events, now);
    values.insert(values.begin(), rates.of_step);
    lock.lock();
    if (state) shown = std::move(state);
    picture = pictures.newest();
    rate = rates.of_second;
    silent_s = seconds(now - last_event);
    minute.add(seconds(now - begun), values);
    ++number;
    has_ended = ends;
    changed.notify_all();
    next = std::max(next + step, Steady::now() + step / 2);  // after long work the next step is no tiny one
    changed.wait_until(lock, next, [this] { return ends; });
  }
}

nlohmann::json LivePage::State::live() const {
  return {{"rate_per_s", rate},
          {"silent_s", silent_s},
          {"picture", picture.number},
          {"picture_us", picture.length.count()},
          {"scene", picture.scene ? characterise::json_of(*picture.scene) : nlohmann::json()},
          {"warnings", picture.warnings}};
}

/// The next message of a client, which has seen the state of that number, and has all steps before `next_step`.
std::optional<std::string> LivePage::State::part(std::uint64_t& seen, std::uint64_t& next_step) {
  std::unique_lock lock(guard);
  if (has_ended && seen == number) return std::nullopt;
  if (!changed.wait_for(lock, step, [&] { return number > seen; })) return std::string();
  nlohmann::json columns = {"events_per_s"};
  for (const std::string& name : options.values) columns.push_back(name);
  const nlohmann::json message = {
      {"state", *shown}, {"live", live()}, {"columns", columns}, {"steps", minute.since(next_step)}, {"ended", has_ended}};
  seen = number;
  next_step = minute.next();
  lock.unlock();
  return "data: " + json_text(message) + "\n\n";
}

LivePage::LivePage(LivePageOptions options) : state_(std::make_unique<State>(std::move(options))) {}

LivePage::~LivePage() {
  {
    const std::scoped_lock lock(state_->guard);
    state_->ends = true;
  }
  state_->changed.notify_all();
  state_->thread.join();
}

EventWatch& LivePage::events() { return state_->watch; }

void LivePage::publish(nlohmann::json state) {
  auto newest = std::make_shared<const nlohmann::json>(std::move(state));
  const std::scoped_lock exchange(state_->inbox);
  state_->newest_state.swap(newest);
}

void LivePage::note(std::span<const double> values) {
  const std::scoped_lock exchange(state_->inbox);
  for (std::size_t i = 0; i < std::min(values.size(), state_->noted.size()); ++i)
    state_->noted[i] = std::fmax(state_->noted[i], values[i]);
}

void LivePage::end(nlohmann::json state) {
  publish(std::move(state));
  constexpr milliseconds patience{500};
  std::unique_lock lock(state_->guard);
  state_->ends = true;
  state_->changed.notify_all();
  state_->changed.wait_for(lock, patience, [this] { return state_->has_ended && state_->viewers == 0; });
}

review::PageResponse LivePage::answer(const review::PageRequest& request) {
  State& state = *state_;
  const bool is_heatmap = request.path == "/api/live/heatmap";
  if (is_heatmap || request.path == "/api/live/events") {
    const std::scoped_lock lock(state.guard);
    const auto& bytes = is_heatmap ? state.picture.heatmap : state.picture.events;
    return bytes ? review::PageResponse{.type = "application/octet-stream", .body = *bytes}
                 : review::PageResponse{.status = 204, .body = {}};
  }
  if (request.path == "/api/live/film" && state.options.film) {
    std::string jpeg = state.options.film();
    return jpeg.empty() ? review::PageResponse{.status = 204, .body = {}}
                        : review::PageResponse{.type = "image/jpeg", .body = std::move(jpeg)};
  }
  if (request.path == "/api/live/choice" && state.options.choose) return chosen(request, state.options);
  if (request.path != "/api/live") throw review::Refusal(404, "there is no such path; expected one of the live page");
  // As long as the answer is being sent.
  const std::shared_ptr<State> viewer(&state, [](State* watched) {
    const std::scoped_lock lock(watched->guard);
    --watched->viewers;
    watched->changed.notify_all();
  });
  ++state.viewers;
  review::PageResponse response{.type = "text/event-stream", .body = {}};
  response.parts = [viewer, seen = std::uint64_t{0}, next_step = std::uint64_t{0}]() mutable {
    return viewer->part(seen, next_step);
  };
  return response;
}

}  // namespace tactile::live
