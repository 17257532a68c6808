#include "tactile/review/review.hpp"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <thread>

#include "tactile/core/error_text.hpp"
#include "tactile/core/text.hpp"
#include "tactile/core/ticks.hpp"
#include "tactile/labels/label_runs.hpp"
#include "tactile/model/bundle/bundle_names.hpp"
#include "tactile/review/label_routes.hpp"
#include "tactile/review/labels_view.hpp"
#include "tactile/review/model_list.hpp"
#include "tactile/review/picture_queue.hpp"
#include "tactile/review/run_store.hpp"
#include "tactile/review/split_desk.hpp"
#include "tactile/review/study_list.hpp"

namespace tactile::review {
namespace {

using nlohmann::json;

constexpr std::int64_t longest_us = 400LL * 24 * 3600 * 1'000'000;  // of a recording: beyond any
constexpr std::int64_t longest_history_us = 1'000'000, longest_snap_us = 100'000;
constexpr std::int64_t most_points = 20'000;
constexpr std::size_t most_snap_events = 20'000;

/// The names in a list such as "event_rate,imu".
std::vector<std::string> names_in(std::string_view list) {
  std::vector<std::string> names;
  while (!list.empty()) {
    const std::size_t end = std::min(list.find(','), list.size());
    if (end > 0) names.emplace_back(list.substr(0, end));
    list.remove_prefix(std::min(end + 1, list.size()));
  }
  return names;
}

PageResponse bytes_response(std::string bytes, const char* type = "application/octet-stream") {
  return {.status = 200, .type = type, .body = std::move(bytes)};
}

PageResponse reading_response(double share) { return json_response({{"state", "reading"}, {"share", share}}, 202); }

/// There is nothing to show, and nothing is wrong.
PageResponse no_content() { return {.status = 204, .type = "", .body = ""}; }

WindowRequest window_in(const PageRequest& request) {
  const WindowRequest window{.from_us = whole_number_of(request, "from_us", -longest_us, longest_us),
                             .to_us = whole_number_of(request, "to_us", -longest_us, longest_us),
                             .points = whole_number_of(request, "points", 1, most_points, 1200),
                             .smooth_us = whole_number_of(request, "smooth_us", 0, longest_us, 0)};
  if (window.from_us >= window.to_us) throw Refusal(400, "'from_us' is not before 'to_us'; expected a part of time");
  return window;
}

[[noreturn]] void refuse_path() { throw Refusal(404, "there is no such path; expected one of this page"); }

}  // namespace

struct Review::State {
  State(ReviewOptions with, ReviewHelp with_help, RunList::Find find)
      : options(std::move(with)),
        help(std::move(with_help)),
        runs(std::move(find), labels),
        store(help.classify),
        pictures(help.draw_labels),
        desk(options.pieces) {}

  ReviewOptions options;
  ReviewHelp help;
  std::shared_ptr<LabelCache> labels = std::make_shared<LabelCache>();
  RunList runs;
  RunStore store;
  PictureQueue pictures;
  SplitDesk desk;
  std::mutex labelling;  ///< one run at a time

  PageResponse of_run(const PageRequest& request, const std::vector<std::string>& parts);
  PageResponse label(const RunFolder& run);
  PageResponse edit(const PageRequest& request, const RunFolder& run, const std::string& what);
  PageResponse split(const PageRequest& request, const RunFolder& run);
  PageResponse of_view(const PageRequest& request, const std::string& what, RunView& view);
  json run_json(const RunView& view);
  json film_json(const RunView& view);
  std::filesystem::path bundle_in(const PageRequest& request) const;

  /// From the first event to the first tick: ticks are whole multiples of camera time.
  std::int64_t tick_origin_us(CameraTime first) const { return between(first, first_tick_from(first, options.tick)).count(); }

  json labels_json(const labels::VersionedLabels& versioned, CameraTime first) const {
    json view = labels_view(versioned, first);
    view["tick_origin_us"] = tick_origin_us(first);
    return view;
  }

  LabelCache::Shared labels_if_read(const RunFolder& run) {
    try {
      return labels->labels_of(run);
    } catch (const Error&) {
      return nullptr;  // the list says so
    }
  }

  /// The film's frames in microseconds after the first event; empty where the film has no clock.
  std::vector<std::int64_t> frame_times(const RunView& view, const FilmFrames& film) {
    std::vector<std::int64_t> times;
    const LabelCache::Shared known = labels_if_read(view.run());
    if (!known || !known->labels.video_clock) return times;
    times.reserve(film.times().size());
    for (const VideoTime t : film.times())
      times.push_back(between(view.events().facts().first, known->labels.video_clock->relation.camera_from(t)).count());
    return times;
  }
};

json Review::State::film_json(const RunView& view) {
  const std::shared_ptr<const FilmFrames> film = view.film();
  if (!film) return nullptr;
  const std::vector<std::int64_t> times = frame_times(view, *film);
  if (times.empty()) return nullptr;
  return {{"width", film->width()},
          {"height", film->height()},
          {"frames", times.size()},
          {"first_us", times.front()},
          {"last_us", times.back()}};
}

json Review::State::run_json(const RunView& view) {
  const RunFacts& facts = view.events().facts();
  const LabelCache::Shared known = labels_if_read(view.run());
  runs.facts(view.run());  // the row has them, though the survey has not come to this run
  json object = runs.row(view.run().object, view.run().run);
  const auto default_model = help.default_model ? help.default_model() : std::nullopt;
  object["history_us"] = options.history.count();
  object["tick_us"] = options.tick.count();
  object["tick_origin_us"] = tick_origin_us(facts.first);
  object["last_event_us"] = between(facts.first, facts.last).count();
  object["default_model"] = default_model ? json(*default_model) : json();
  object["models"] = model::bundle_names(options.models);
  object["signals"] = view.signals(known ? &known->labels : nullptr);
  object["film"] = film_json(view);
  object["film_pending"] = view.film_is_pending();
  std::vector<std::string> remarks = view.remarks();
  if (known) remarks.insert(remarks.end(), known->labels.remarks.begin(), known->labels.remarks.end());
  object["remarks"] = remarks;
  return object;
}

std::filesystem::path Review::State::bundle_in(const PageRequest& request) const {
  const std::string name = text_of(request, "model");
  if (name.empty()) return {};
  const std::vector<std::string> names = model::bundle_names(options.models);
  if (std::find(names.begin(), names.end(), name) == names.end())
    throw Refusal(404, "there is no model " + shown_text(name) + "; expected one of the list");
  return options.models / name;
}

PageResponse Review::State::of_view(const PageRequest& request, const std::string& what, RunView& view) {
  const RunEvents& events = view.events();
  const auto at = [&](const char* name) {
    return after(events.facts().first, microseconds{whole_number_of(request, name, -longest_us, longest_us)});
  };
  const auto history = [&] {
    return microseconds{whole_number_of(request, "history_us", 1, longest_history_us, options.history.count())};
  };
  if (what.empty()) return json_response(run_json(view));
  if (what == "events") return bytes_response(events.counts_before(at("at_us"), history()));
  if (what == "heatmap") return bytes_response(events.heatmap_before(at("at_us"), history()));
  if (what == "signals") {
    const LabelCache::Shared known = labels_if_read(view.run());
    return json_response(view.windows(names_in(text_of(request, "names")), window_in(request), known ? &known->labels : nullptr,
                                      bundle_in(request)));
  }
  if (what == "event_times") {
    const WindowRequest window = window_in(request);
    if (window.to_us - window.from_us > longest_snap_us) throw Refusal(400, "the window is too long; expected at most 100 ms");
    const auto found = events.events_in(at("from_us"), at("to_us"), most_snap_events);
    if (!found) return json_response({{"t_us", json::array()}, {"too_many", true}});
    std::vector<std::int64_t> times;
    times.reserve(found->size());
    for (const events::Event& event : *found) times.push_back(between(events.facts().first, event.t).count());
    std::sort(times.begin(), times.end());
    return json_response({{"t_us", times}, {"too_many", false}});
  }
  const std::shared_ptr<const FilmFrames> film = view.film();
  if (!film && view.film_is_pending()) return reading_response(0);
  const std::vector<std::int64_t> times = film ? frame_times(view, *film) : std::vector<std::int64_t>();
  if (times.empty()) throw Refusal(404, "the run has no film that can be shown; expected a film with a clock");
  if (what == "frames") return json_response({{"t_us", times}});
  if (what != "film") refuse_path();
  const auto next = std::upper_bound(times.begin(), times.end(), whole_number_of(request, "at_us", -longest_us, longest_us));
  if (next == times.begin()) return no_content();
  PageResponse response = bytes_response(film->jpeg(static_cast<std::size_t>(next - times.begin() - 1)), "image/jpeg");
  response.headers.emplace_back("X-Frame-Us", std::to_string(*(next - 1)));
  return response;
}

/// As `tactile label` does it without options.
PageResponse Review::State::label(const RunFolder& run) {
  const std::scoped_lock one_at_a_time(labelling);
  const labels::RunOutcome outcome = labels::label_runs({run}).front();
  if (!outcome.error.empty()) throw Refusal(500, outcome.error);
  pictures.draw(run, outcome.labels);
  return json_response(labels_json(*labels->labels_of(run), runs.facts(run).first));
}

PageResponse Review::State::edit(const PageRequest& request, const RunFolder& run, const std::string& what) {
  const json body = json_in(request);
  const CameraTime first = runs.facts(run).first;
  const labels::SaveOutcome outcome =
      what == "edits" ? save_asked_edit(run, body, first, options.who) : save_asked_step(run, body, what == "undo");
  if (const auto* conflict = std::get_if<labels::EditConflict>(&outcome)) {
    return json_response({{"error", "the labels have changed in the meantime; nothing was saved"},
                          {"current", labels_json(conflict->current, first)}},
                         409);
  }
  const auto& saved = std::get<labels::VersionedLabels>(outcome);
  pictures.draw(run, saved.labels);
  return json_response(labels_json(saved, first));
}

PageResponse Review::State::split(const PageRequest& request, const RunFolder& run) {
  if (request.method == "GET")
    return json_response(desk.look(run, microseconds{1000 * whole_number_of(request, "quiet_ms", 50, 3'600'000, 2'000)}));
  const json body = json_in(request);
  std::vector<microseconds> cuts;
  std::vector<std::string> objects;
  try {
    for (const std::int64_t cut : body.at("cuts_us").get<std::vector<std::int64_t>>()) {
      if (cut <= 0 || cut > longest_us)
        throw Refusal(400, "a cut lies outside the recording; expected one after its first event");
      cuts.emplace_back(cut);
    }
    objects = body.at("objects").get<std::vector<std::string>>();
  } catch (const json::exception&) {
    throw Refusal(400, "the request is no cut; expected 'cuts_us', a list of whole numbers, and 'objects', a list of names");
  }
  return json_response(desk.cut(run, cuts, objects));
}

PageResponse Review::State::of_run(const PageRequest& request, const std::vector<std::string>& parts) {
  const RunFolder run = runs.find(parts[2], parts[3]);
  const std::string what = parts.size() > 4 ? parts[4] : "";
  if (parts.size() > 5) refuse_path();
  const bool is_label = what == "label", is_edit = what == "edits" || what == "undo" || what == "redo";
  if ((is_label || is_edit) != (request.method == "POST"))
    throw Refusal(405, is_label || is_edit ? "this path is sent to by POST" : "this path is asked for by GET");
  if (is_label) return label(run);
  if (is_edit) return edit(request, run, what);
  if (what == "thumbnail") {
    const std::optional<std::string> picture = runs.thumbnail(run);
    if (!picture) return reading_response(0);
    return picture->empty() ? no_content() : bytes_response(*picture, "image/png");
  }
  if (what == "labels") {
    const LabelCache::Shared known = labels->labels_of(run);
    if (!known) throw Refusal(404, run.name() + ": has no labels; 'tactile label' makes them");
    return json_response(labels_json(*known, runs.facts(run).first));
  }
  const std::shared_ptr<RunView> view = store.open(run);
  const RunView::State state = view->state();
  if (!state.error.empty()) throw Refusal(500, state.error);
  if (!state.is_read) return reading_response(state.share);
  return of_view(request, what, *view);
}

Review::Review(ReviewOptions options, ReviewHelp help, RunList::Find find)
    : state_(std::make_unique<State>(std::move(options), std::move(help), std::move(find))) {}

Review::~Review() = default;

PageResponse Review::answer(const PageRequest& request) {
  const std::vector<std::string> parts = parts_of(request.path);
  if (parts.size() < 2 || parts[0] != "api") refuse_path();
  const std::string& what = parts[1];
  if (what == "runs" && parts.size() >= 4) return state_->of_run(request, parts);
  if (what == "splits" && parts.size() == 4) return state_->split(request, state_->runs.find(parts[2], parts[3]));
  if (parts.size() != 2) refuse_path();
  if (request.method != "GET") throw Refusal(405, "this path is asked for by GET");
  if (what == "runs") {
    json table = state_->runs.table();
    table["data"] = state_->options.data;
    return json_response(table);
  }
  if (what == "who") return json_response({{"who", state_->options.who}});
  if (what == "models") return json_response(models_json(state_->options.models));
  if (what == "studies") return json_response(studies_json(state_->options.studies, state_->options.models));
  refuse_path();
}

}  // namespace tactile::review
