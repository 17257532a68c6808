#include "viewed_recording.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include "tactile/bags/bag.hpp"
#include "tactile/core/duration_units.hpp"
#include "tactile/core/error.hpp"
#include "tactile/events/simulated_recording.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;

std::unique_ptr<BagRecording> recording_of_bag(const std::string& what, const CommonArguments& common) {
  return bags::is_bag(what) ? std::make_unique<BagRecording>(what, conversion::BagImportOptions{}, common) : nullptr;
}

}  // namespace

ViewedRecording::ViewedRecording(const std::string& what, const std::string& stream, const CommonArguments& common)
    : from_bag_(recording_of_bag(what, common)),
      run_(!from_bag_ && fs::is_directory(what) ? std::optional(run_folder_at(what)) : std::nullopt),
      reader_(from_bag_ ? from_bag_->file() : (run_ ? recording_in(what) : fs::path(what)), common.threads) {
  const events::Stream& chosen = events::event_stream(reader_, stream);
  file_ = from_bag_ ? what : reader_.file().string();
  if (!chosen.size) throw Error(fmt::format("{}: stream {} declares no size; expected its sensor's", file_, chosen.id));
  stream_id_ = chosen.id;
  source_ = chosen.source;
  sensor_ = *chosen.size;
  const fs::path shown = fs::absolute(what).lexically_normal();
  const fs::path file_shown = shown.has_filename() ? shown : shown.parent_path();
  name_ = run_ ? run_->name() : file_shown.filename().string();
  stem_ = file_shown.stem().string();
  const RunFolder around = run_ ? *run_ : run_folder_at(fs::absolute(reader_.file()).parent_path());
  const bool is_of_run = !from_bag_ && reader_.file().filename() == around.events().filename();
  simulated_ = is_of_run ? events::is_simulated(around) : events::is_simulated(reader_.streams());
  if (run_ && fs::exists(run_->labels())) {
    labelled_ = true;
    for (const labels::LabelledInterval& interval : labels::read_labels(run_->labels()).intervals)
      intervals_.push_back(interval.interval());
  }
  const ProgressCallback progress = progress_line(common);
  const std::uint64_t all = reader_.packets().size();
  std::uint64_t packets = 0;
  events::for_all_events(reader_, stream_id_, [&](std::span<const events::Event> packet) {
    report_progress(progress, ++packets, all, "reading " + name_);
    if (!curve_) {
      first_ = packet.front().t;
      curve_.emplace(first_);
    }
    last_ = packet.back().t;
    events_ += packet.size();
    curve_->add(packet);
  });
  if (!curve_) throw Error(file_ + ": holds no event; expected a recording with events");
}

std::string ViewedRecording::camera() const {
  return fmt::format("{}, {}x{} px", source_.empty() ? "events" : source_, sensor_.width, sensor_.height);
}

std::string ViewedRecording::file_stem() const { return run_ ? run_->object + "-" + run_->run : stem_; }

double ViewedRecording::ms_from_first(CameraTime t) const { return in_ms(between(first_, t)); }

std::optional<Touch> ViewedRecording::touch_at(CameraTime t) const {
  if (!labelled_) return std::nullopt;
  const auto contains = [&](const TouchInterval& interval) { return interval.contains(t); };
  const auto current = std::find_if(intervals_.begin(), intervals_.end(), contains);
  return current == intervals_.end() ? Touch::none : current->touch;
}

TickRange ViewedRecording::ticks(const heatmaps::HeatmapOptions& options) const {
  const TickRange range = full_ticks(first_, last_, options.history, options.tick);
  if (range.count == 0) {
    throw Error(
        fmt::format("{}: is {:.1f} ms long, less than one full history of {:g} ms; expected a longer recording or a smaller --th",
                    file_, ms_from_first(last_), in_ms(options.history)));
  }
  return range;
}

TickRange ViewedRecording::ticks_between(const heatmaps::HeatmapOptions& options, std::optional<double> from_ms,
                                         std::optional<double> to_ms) const {
  TickRange range = ticks(options);
  const CameraTime last_tick = range.at(range.count - 1);
  const auto after_first = [&](double ms) { return after(first_, microseconds{std::llround(ms * 1000)}); };
  if (from_ms && to_ms && *from_ms > *to_ms)
    throw Error(fmt::format("--from-ms {:g}: is after --to-ms {:g}; expected a start before the end", *from_ms, *to_ms));
  const CameraTime begin = std::max(range.first, first_tick_from(from_ms ? after_first(*from_ms) : range.first, options.tick));
  const CameraTime end = std::min(last_tick, last_tick_until(to_ms ? after_first(*to_ms) : last_tick, options.tick));
  if (begin > end) {
    const std::string option = from_ms && begin > last_tick ? fmt::format("--from-ms {:g}", *from_ms)
                               : to_ms && end < range.first ? fmt::format("--to-ms {:g}", *to_ms)
                                                            : fmt::format("--from-ms {:g} --to-ms {:g}", *from_ms, *to_ms);
    throw Error(fmt::format("{}: there is no tick with a full history; expected times between {:.1f} and {:.1f} ms", option,
                            ms_from_first(range.first), ms_from_first(last_tick)));
  }
  range.first = begin;
  range.count = between(begin, end) / options.tick + 1;
  return range;
}

nlohmann::json ViewedRecording::json() const {
  return {{"file", file_},
          {"simulated", simulated_},
          {"sensor", {{"width", sensor_.width}, {"height", sensor_.height}}},
          {"labelled", labelled_}};
}

}  // namespace tactile::cli
