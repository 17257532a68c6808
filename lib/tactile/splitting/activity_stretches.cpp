#include "tactile/splitting/activity_stretches.hpp"

#include <algorithm>
#include <numeric>

#include "tactile/core/robust_statistics.hpp"

namespace tactile::splitting {
namespace {

/// Bins [begin, end).
struct Bins {
  std::size_t begin = 0, end = 0;
};

std::size_t bins_in(microseconds span, const alignment::EventRate& rate) {
  return static_cast<std::size_t>(std::max<std::int64_t>(1, span / rate.bin));
}

/// The stretches between pauses; all begin and end with an event.
std::vector<Bins> recorded_stretches(const alignment::EventRate& rate, std::size_t pause) {
  std::vector<Bins> stretches;
  for (std::size_t i = 0; i < rate.counts.size(); ++i) {
    if (rate.counts[i] == 0) continue;
    if (stretches.empty() || i - stretches.back().end >= pause) stretches.push_back({i, i});
    stretches.back().end = i + 1;
  }
  return stretches;
}

alignment::EventRate part_of(const alignment::EventRate& rate, Bins bins) {
  alignment::EventRate part;
  part.begin = rate.begin_of(bins.begin);
  part.bin = rate.bin;
  part.counts.assign(rate.counts.begin() + static_cast<std::ptrdiff_t>(bins.begin),
                     rate.counts.begin() + static_cast<std::ptrdiff_t>(bins.end));
  return part;
}

/// Looks for the bursts of one stretch, part by part.
class StretchSearch {
 public:
  StretchSearch(const alignment::EventRate& rate, const LongActivityOptions& options, LongActivity& found,
                std::vector<alignment::QuietRate>& quiet_rates)
      : rate_(rate), options_(options), found_(found), quiet_rates_(quiet_rates) {}

  void search(Bins stretch) {
    const std::size_t before = found_.bursts.size(), rates_before = quiet_rates_.size();
    constexpr microseconds needed_for_quiet = 500ms;
    if (stretch.end - stretch.begin >= bins_in(needed_for_quiet, rate_)) {
      const std::size_t length = bins_in(options_.part, rate_);
      for (std::size_t begin = stretch.begin; begin < stretch.end; begin += length)
        search_part(stretch, {begin, std::min(stretch.end, begin + length)});
    }
    if (found_.bursts.size() > before) return;
    constexpr double least = 100.0;
    const auto first = rate_.counts.begin();
    const double events = std::accumulate(first + static_cast<std::ptrdiff_t>(stretch.begin),
                                          first + static_cast<std::ptrdiff_t>(stretch.end), 0.0);
    const bool pauses = stretch.begin > 0 || stretch.end < rate_.counts.size();
    if (!pauses || events < least || stretch.end - stretch.begin < bins_in(options_.bursts.shortest, rate_)) return;
    found_.bursts.push_back({.begin = stretch.begin, .end = stretch.end, .events = events});
    quiet_rates_.resize(rates_before);  // what moves all the time shows no quiet rate
  }

 private:
  void search_part(Bins stretch, Bins core) {
    const std::size_t margin = bins_in(options_.margin, rate_);
    const Bins wide{core.begin - std::min(core.begin - stretch.begin, margin), std::min(stretch.end, core.end + margin)};
    const alignment::EventRate part = part_of(rate_, wide);
    const alignment::QuietRate quiet = alignment::quiet_rate(part);
    quiet_rates_.push_back(quiet);
    for (alignment::Burst burst : alignment::bursts_in(part, quiet, options_.bursts)) {
      burst.begin += wide.begin;
      burst.end += wide.begin;
      const bool continues = !found_.bursts.empty() && burst.begin <= found_.bursts.back().end;
      if (continues) {
        found_.bursts.back().end = std::max(found_.bursts.back().end, burst.end);
      } else if (burst.begin >= core.begin && burst.begin < core.end) {
        found_.bursts.push_back(burst);
      }
    }
  }

  const alignment::EventRate& rate_;
  const LongActivityOptions& options_;
  LongActivity& found_;
  std::vector<alignment::QuietRate>& quiet_rates_;
};

}  // namespace

LongActivity activity_in(const alignment::EventRate& rate, const LongActivityOptions& options) {
  LongActivity found;
  std::vector<alignment::QuietRate> quiet_rates;
  StretchSearch search(rate, options, found, quiet_rates);
  std::size_t recorded_until = 0;
  for (const Bins& stretch : recorded_stretches(rate, bins_in(options.silence, rate))) {
    search.search(stretch);
    if (stretch.begin > recorded_until) found.pauses.push_back({.begin = recorded_until, .end = stretch.begin});
    recorded_until = stretch.end;
  }
  if (quiet_rates.empty()) return found;
  found.quiet = value_of_rank<alignment::QuietRate>(
      quiet_rates, quiet_rates.size() / 2,
      [](const alignment::QuietRate& a, const alignment::QuietRate& b) { return a.mean < b.mean; });
  found.has_quiet = true;
  return found;
}

}  // namespace tactile::splitting
