#include "tick_reader.hpp"

#include <fmt/core.h>

#include <utility>

#include "camera_time.hpp"
#include "command.hpp"
#include "interruption.hpp"
#include "quantity_text.hpp"
#include "standard_streams.hpp"
#include "tactile/core/csv_table.hpp"
#include "tactile/core/duration_units.hpp"
#include "tactile/core/error.hpp"
#include "tactile/model/inference/tick_cells.hpp"

namespace tactile::cli {
namespace {

constexpr std::size_t kept_at_most = 2'000'000;  // more than an hour

}  // namespace

TickReader::TickReader(TickReaderOptions options, LiveLine& line) : options_(std::move(options)), line_(line) {
  if (options_.csv.empty()) return;
  file_.open(options_.csv, std::ios::binary | std::ios::trunc);
  file_ << model::tick_columns << ",predicted,events,closed,skipped,beginning,incomplete,slip_confirmed\n";
  check_file();
}

detect::TickOutput TickReader::output() {
  return {.episode = [this](const detect::ReportedTick& tick) { begin_episode(tick); },
          .confirmed = [this](const detect::VerdictEpisode& episode) { confirm(episode); },
          .episode_end = [this](const detect::VerdictEpisode& episode) { end_episode(episode); },
          .ticks = [this](std::span<const detect::ReportedTick> ticks) { read(ticks); },
          .end = [this] { end(); },
          .interrupted = interrupted};
}

void TickReader::check_file() const {
  if (!file_) throw Error(options_.csv + ": cannot be written; expected a place with room");
}

void TickReader::read(std::span<const detect::ReportedTick> ticks) {
  for (const detect::ReportedTick& tick : ticks) {
    skipped_ += tick.due.skipped;
    if (options_.keeps) kept_.size() < kept_at_most ? kept_.push_back(tick) : void(++not_kept_);
    if (!options_.csv.empty()) write(tick);
  }
  if (!options_.csv.empty() && !ticks.empty()) check_file();
  if (!ticks.empty()) newest_ = ticks.back();
  draw();
}

void TickReader::write(const detect::ReportedTick& tick) {
  const detect::TickVerdict& verdict = tick.verdict;
  file_ << csv_row(model::tick_cells(verdict.t, verdict.probabilities, verdict.verdict), name_of(verdict.predicted),
                   verdict.events, tick.due.by_events ? "event" : "host", tick.due.skipped, tick.beginning,
                   tick.incomplete ? 1 : 0, verdict.slip_is_confirmed ? 1 : 0)
        << '\n';
}

void TickReader::end() {
  if (options_.csv.empty()) return;
  file_.close();
  check_file();
}

void TickReader::begin_episode(const detect::ReportedTick& tick) {
  if (!options_.prints) return;
  line_.clear();
  const Touch touch = tick.verdict.verdict;
  zero_ = zero_of_times(options_.camera_time, tick.first_event);
  print(fmt::format("{:<5} at {:.6f} s, probability {:.3f}\n", name_of(touch), in_s(between(zero_, tick.verdict.t)),
                    static_cast<double>(tick.verdict.probabilities[static_cast<std::size_t>(touch)])));
}

void TickReader::confirm(const detect::VerdictEpisode& episode) {
  if (!options_.prints) return;
  line_.clear();
  print(fmt::format("slip  confirmed at {:.6f} s, {:.0f} ms after its beginning\n", in_s(between(zero_, *episode.confirmed)),
                    in_ms(between(episode.first, *episode.confirmed))));
}

void TickReader::end_episode(const detect::VerdictEpisode& episode) {
  if (!options_.prints) return;
  line_.clear();
  print(fmt::format("{:<5} until {:.6f} s, {:.3f} s long\n", name_of(episode.touch), in_s(between(zero_, episode.last)),
                    in_s(between(episode.first, episode.last))));
}

void TickReader::draw() {
  const std::chrono::steady_clock::time_point now = std::chrono::steady_clock::now();
  if (!line_.draws() || !newest_ || now - drawn_ < 250ms) return;
  drawn_ = now;
  const detect::TickVerdict& verdict = newest_->verdict;
  const double seconds = std::chrono::duration<double>(now - begun_).count();
  line_.draw(fmt::format("{}  {:<5} {:.2f}  {} events in t_h  {}  {} skipped", clock_text(seconds), name_of(verdict.verdict),
                         static_cast<double>(verdict.probabilities[static_cast<std::size_t>(verdict.predicted)]), verdict.events,
                         counted(newest_->number + 1, "tick"), skipped_));
}

}  // namespace tactile::cli
