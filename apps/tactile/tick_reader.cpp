#include "tick_reader.hpp"

#include <fmt/core.h>

#include <utility>

#include "command.hpp"
#include "quantity_text.hpp"
#include "standard_streams.hpp"
#include "tactile/core/error.hpp"

namespace tactile {
namespace {

constexpr std::size_t kept_at_most = 2'000'000;  // more than an hour

}  // namespace

TickReader::TickReader(TickReaderOptions options, LiveLine& line, DetectSummary& summary)
    : options_(std::move(options)), line_(line), summary_(summary) {
  if (options_.csv.empty()) return;
  file_.open(options_.csv, std::ios::binary | std::ios::trunc);
  file_ << "t_us,p_none,p_press,p_slip,verdict,said,events,gated,closed,skipped,beginning,incomplete\n";
  check_file();
}

void TickReader::check_file() const {
  if (!file_) throw Error(options_.csv + ": cannot be written; expected a place with room");
}

void TickReader::read(TickLog& log) {
  log.take(ticks_);
  for (const ToldTick& tick : ticks_) read(tick);
  if (!options_.csv.empty() && !ticks_.empty()) check_file();
  if (!ticks_.empty()) newest_ = ticks_.back();
  draw();
}

void TickReader::end() {
  if (options_.csv.empty()) return;
  file_.close();
  check_file();
}

void TickReader::read(const ToldTick& tick) {
  const TickVerdict& verdict = tick.verdict;
  const auto touch = static_cast<std::size_t>(verdict.verdict);
  ++summary_.verdicts[touch];
  skipped_ += tick.due.skipped;
  if (!summary_.first_tick) summary_.first_tick = verdict.t;
  summary_.last_tick = verdict.t;
  const bool goes_on = last_ == verdict.verdict && beginning_ == tick.beginning;
  if (verdict.verdict != Touch::none && !goes_on) begin_episode(tick);
  if (verdict.verdict != Touch::none && goes_on && episode_is_kept_) summary_.first_episodes.back().last = verdict.t;
  last_ = verdict.verdict;
  beginning_ = tick.beginning;
  if (options_.keeps) kept_.size() < kept_at_most ? kept_.push_back(tick) : void(++not_kept_);
  if (options_.csv.empty()) return;
  const Probabilities& p = verdict.probabilities;
  file_ << fmt::format("{},{:.9g},{:.9g},{:.9g},{},{},{},{},{},{},{},{}\n", us_of(verdict.t), p[0], p[1], p[2],
                       name_of(verdict.verdict), name_of(verdict.said), verdict.events, verdict.gated ? 1 : 0,
                       tick.due.by_events ? "event" : "host", tick.due.skipped, tick.beginning, tick.incomplete ? 1 : 0);
}

void TickReader::begin_episode(const ToldTick& tick) {
  const Touch touch = tick.verdict.verdict;
  ++summary_.episodes[static_cast<std::size_t>(touch)];
  episode_is_kept_ = summary_.first_episodes.size() < most_episodes_told;
  if (episode_is_kept_) summary_.first_episodes.push_back({touch, tick.verdict.t, tick.verdict.t});
  if (!options_.prints) return;
  line_.clear();
  const double seconds = 1e-6 * static_cast<double>(us_of(tick.verdict.t));
  print(fmt::format("{:<5} at {:.6f} s, probability {:.3f}\n", name_of(touch), seconds,
                    static_cast<double>(tick.verdict.probabilities[static_cast<std::size_t>(touch)])));
}

void TickReader::draw() {
  const std::chrono::steady_clock::time_point now = std::chrono::steady_clock::now();
  if (!line_.draws() || !newest_ || now - drawn_ < 250ms) return;
  drawn_ = now;
  const TickVerdict& verdict = newest_->verdict;
  const double seconds = std::chrono::duration<double>(now - begun_).count();
  line_.draw(fmt::format("{}  {:<5} {:.2f}  {} events in t_h  {}  {} skipped", clock_text(seconds), name_of(verdict.verdict),
                         static_cast<double>(verdict.probabilities[static_cast<std::size_t>(verdict.said)]), verdict.events,
                         counted(newest_->number + 1, "tick"), skipped_));
}

}  // namespace tactile
