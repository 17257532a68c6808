#include "tactile/review/run_list.hpp"

#include <algorithm>
#include <filesystem>

#include "tactile/core/error.hpp"
#include "tactile/core/error_text.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/review/labels_view.hpp"
#include "tactile/review/page_message.hpp"
#include "tactile/review/rate_counts.hpp"

namespace tactile::review {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::chrono::seconds look_again{1};
constexpr microseconds history_shown = 40ms, peak_over = 2ms;
constexpr int widest_thumbnail = 160;  // [px]

void check_names(const RunsBelow& found) {
  std::map<std::string, fs::path> folders;
  for (const RunFolder& run : found.runs) {
    const auto [other, is_new] = folders.emplace(run.name(), run.folder);
    if (!is_new)
      throw Error(run.name() + ": is in " + other->second.string() + " and in " + run.folder.string() +
                  "; expected each run once");
  }
}

CameraTime first_event_of(const labels::Labels& labels, const std::optional<RunFacts>& facts) {
  if (facts) return facts->first;
  const auto us = labels.provenance.find("first_event_us");
  return us != labels.provenance.end() && us->is_number_integer() ? camera_time(us->get<std::int64_t>()) : CameraTime::min();
}

json intervals_json(const labels::Labels& labels, CameraTime first) {
  json list = json::array();
  for (const labels::LabelledInterval& interval : labels.intervals) {
    list.push_back({{"id", interval.id},
                    {"touch", name_of(interval.touch)},
                    {"start_us", between(first, interval.start.at).count()},
                    {"end_us", between(first, interval.end.at).count()},
                    {"confirmed", interval.confirmed},
                    {"source", interval.source}});
  }
  return list;
}

}  // namespace

RunList::RunList(Find find, std::shared_ptr<LabelCache> labels)
    : find_(std::move(find)), labels_(std::move(labels)), found_(find_()), looked_(std::chrono::steady_clock::now()) {
  check_names(found_);
  surveys_ = std::thread([this] { survey_runs(); });
}

RunList::~RunList() {
  {
    const std::scoped_lock lock(guard_);
    ends_ = true;
  }
  changed_.notify_all();
  surveys_.join();
}

void RunList::refresh() {
  {
    const std::scoped_lock lock(guard_);
    const auto now = std::chrono::steady_clock::now();
    if (now - looked_ < look_again) return;
    looked_ = now;
  }
  RunsBelow found;
  try {
    found = find_();
    check_names(found);
  } catch (const Error& e) {
    found.unreadable = {sentence_of(e)};
  }
  const std::scoped_lock lock(guard_);
  found_ = std::move(found);
  changed_.notify_all();
}

RunFolder RunList::find(const std::string& object, const std::string& run) {
  const auto known = [&]() -> std::optional<RunFolder> {
    const std::scoped_lock lock(guard_);
    const auto found = std::find_if(found_.runs.begin(), found_.runs.end(),
                                    [&](const RunFolder& one) { return one.object == object && one.run == run; });
    return found == found_.runs.end() ? std::nullopt : std::optional(*found);
  };
  if (const auto found = known()) return *found;  // without a look at all folders, which takes long
  refresh();
  if (const auto found = known()) return *found;
  throw Refusal(404, "there is no such run; expected one of the list");
}

RunList::Row RunList::row_of(const RunFolder& run) {
  const std::string stamp = stamp_of(run.events());
  const std::scoped_lock lock(guard_);
  const auto found = known_.find(run.name());
  return {run, found != known_.end() && found->second.stamp == stamp ? found->second : Known{.stamp = stamp}};
}

RunFacts RunList::facts(const RunFolder& run) {
  const Row row = row_of(run);
  if (row.known.facts) return *row.known.facts;
  const RunFacts facts = read_facts(run);
  const std::scoped_lock lock(guard_);
  Known& known = known_[run.name()];
  if (known.stamp != row.known.stamp) known = {.stamp = row.known.stamp};
  known.facts = facts;
  return facts;
}

std::optional<std::string> RunList::thumbnail(const RunFolder& run) {
  const Row row = row_of(run);
  if (!row.known.error.empty()) return std::string();
  std::optional<CameraTime> end;
  if (const LabelCache::Shared labels = labels_->labels_of(run)) {
    for (const labels::LabelledInterval& interval : labels->labels.intervals) {
      if (interval.touch == Touch::press && !end) end = after(interval.start.at, history_shown);
    }
  }
  if (!end && row.known.survey) end = row.known.survey->busiest_end;
  if (!end || !row.known.facts) return std::nullopt;
  if (row.known.facts->sensor == events::SensorSize{}) return std::string();
  const std::string shown = std::to_string(us_of(*end));
  if (row.known.thumbnail_of == shown) return *row.known.thumbnail;
  std::string picture = RunEvents(run).picture_before(*end, history_shown, widest_thumbnail);
  const std::scoped_lock lock(guard_);
  Known& known = known_[run.name()];
  if (known.stamp == row.known.stamp) {
    known.thumbnail = std::make_shared<const std::string>(picture);
    known.thumbnail_of = shown;
  }
  return picture;
}

json RunList::json_of(const Row& row) {
  const std::optional<RunFacts>& facts = row.known.facts;
  const std::optional<RunSurvey>& survey = row.known.survey;
  const auto if_known = [](bool is_known, const auto& value) { return is_known ? json(value) : json(); };
  const double length_s = facts ? facts->length_s() : 0;
  const bool has_rate = facts && length_s > 0;
  json object = {{"name", row.run.name()},
                 {"object", row.run.object},
                 {"run", row.run.run},
                 {"length_s", if_known(facts.has_value(), length_s)},
                 {"events", if_known(facts.has_value(), facts ? facts->events : 0)},
                 {"rate_mean_per_s", if_known(has_rate, has_rate ? static_cast<double>(facts->events) / length_s : 0)},
                 {"rate_peak_per_s", if_known(survey.has_value(), survey ? survey->peak_per_s : 0)},
                 {"width", if_known(facts && facts->sensor.width > 0, facts ? facts->sensor.width : 0)},
                 {"height", if_known(facts && facts->sensor.height > 0, facts ? facts->sensor.height : 0)},
                 {"simulated", if_known(facts.has_value(), facts && facts->simulated)},
                 {"first_event_us", if_known(facts.has_value(), facts ? us_of(facts->first) : 0)},
                 {"flags", json::array()},
                 {"open_flags", 0},
                 {"clocks", nullptr},
                 {"intervals", json::array()},
                 {"confirmed", false},
                 {"error", row.known.error.empty() ? json() : json(row.known.error)}};
  object["has"] = {{"robot", is_there(row.run.robot())},
                   {"video", is_there(row.run.video())},
                   {"imu", if_known(facts.has_value(), facts && facts->has_imu)},
                   {"labels", false}};
  try {
    const LabelCache::Shared labels = labels_->labels_of(row.run);
    if (!labels) return object;
    const CameraTime first = first_event_of(labels->labels, facts);
    object["has"]["labels"] = true;
    object["flags"] = flags_view(labels->labels);
    object["open_flags"] = open_flags(labels->labels);
    object["clocks"] = clocks_view(labels->labels);
    if (first != CameraTime::min()) object["intervals"] = intervals_json(labels->labels, first);
    object["confirmed"] = is_confirmed(labels->labels);
  } catch (const std::exception& e) {
    object["error"] = sentence_of(e, row.run.name());
  }
  return object;
}

json RunList::row(const std::string& object, const std::string& run) { return json_of(row_of(find(object, run))); }

json RunList::table() {
  refresh();
  RunsBelow found;
  {
    const std::scoped_lock lock(guard_);
    found = found_;
  }
  nlohmann::json rows = nlohmann::json::array();
  std::size_t confirmed = 0, flagged = 0;
  for (const RunFolder& run : found.runs) {
    rows.push_back(json_of(row_of(run)));
    confirmed += rows.back().at("confirmed").get<bool>() ? 1 : 0;
    flagged += rows.back().at("open_flags").get<std::size_t>() > 0 ? 1 : 0;
  }
  std::vector<std::string> left_out = found.misnamed;
  left_out.insert(left_out.end(), found.unreadable.begin(), found.unreadable.end());
  nlohmann::json all = {{"progress", {{"runs", rows.size()}, {"confirmed", confirmed}, {"flagged", flagged}}},
                        {"left_out", left_out},
                        {"runs", std::move(rows)}};
  all["revision"] = sha256_of(all.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)).substr(0, 16);
  return all;
}

std::optional<RunFolder> RunList::next_to_survey() {
  std::vector<RunFolder> runs;
  {
    const std::scoped_lock lock(guard_);
    runs = found_.runs;
  }
  std::optional<RunFolder> smallest;
  std::uintmax_t least = 0;
  for (const RunFolder& run : runs) {
    const Row row = row_of(run);
    if (row.known.survey || !row.known.error.empty()) continue;
    std::error_code missing;
    const std::uintmax_t size = fs::file_size(run.events(), missing);
    if (!smallest || size < least) {
      smallest = run;
      least = size;
    }
  }
  return smallest;
}

void RunList::survey_runs() {
  while (!ends_) {
    if (const std::optional<RunFolder> run = next_to_survey()) {
      survey(*run);
      continue;
    }
    std::unique_lock lock(guard_);
    if (!ends_) changed_.wait(lock);
  }
}

void RunList::survey(const RunFolder& run) {
  Known known{.stamp = stamp_of(run.events())};
  const auto publish = [&] {
    const std::scoped_lock lock(guard_);
    Known& now = known_[run.name()];
    if (now.stamp == known.stamp) {
      known.thumbnail = now.thumbnail;
      known.thumbnail_of = now.thumbnail_of;
    }
    now = known;
  };
  try {
    const RunEvents events(run);
    known.facts = events.facts();
    publish();
    RateCounts rate(known.facts->first, known.facts->last);
    events.for_all([&](std::span<const events::Event> some) { rate.add(some); },
                   [&](double) {
                     if (ends_) throw Cancelled{};
                   });
    const RateCounts::Busiest peak = rate.busiest(peak_over), busiest = rate.busiest(history_shown);
    const double over_s = 1e-6 * static_cast<double>(std::max(peak_over, rate.bin()).count());
    const microseconds until = rate.bin() * static_cast<std::int64_t>(busiest.begin) + history_shown;
    known.survey = {.peak_per_s = static_cast<double>(peak.events) / over_s, .busiest_end = after(known.facts->first, until)};
  } catch (const Cancelled&) {
    return;
  } catch (const std::exception& e) {
    known.error = sentence_of(e, run.name());
  }
  publish();
}

}  // namespace tactile::review
