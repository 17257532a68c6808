#include "tactile/characterise/quiet_stretches.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

namespace tactile::characterise {

void QuietMeter::add(std::span<const events::Event> events) {
  for (const events::Event& event : events) {
    if (bins_.empty()) {
      bins_.emplace_back();
      begin_ = first_ = last_ = event.t;
    }
    first_ = std::min(first_, event.t);
    last_ = std::max(last_, event.t);
    const std::int64_t index = between(begin_, event.t).count() / bin_us;
    if (index > bins_.back().index) bins_.push_back({.index = index});  // an earlier one counts in the last
    const int row = event.y * side / size_.height, column = event.x * side / size_.width;
    ++bins_.back().counts[static_cast<std::size_t>(row) * side + static_cast<std::size_t>(column)];
  }
}

std::pair<std::size_t, std::size_t> QuietMeter::quietest_bins() const {
  const auto events_in = [](const Bin& bin) { return std::accumulate(bin.counts.begin(), bin.counts.end(), 0.0); };
  const std::int64_t end = bins_.back().index;  // the last bin is not full
  std::pair<std::size_t, std::size_t> quietest(0, bins_.size());
  std::size_t from = 0, to = 0;
  double events = 0, fewest = std::numeric_limits<double>::infinity();
  for (; from < bins_.size() && bins_[from].index + reference_bins <= end; events -= events_in(bins_[from++])) {
    for (; to < bins_.size() && bins_[to].index < bins_[from].index + reference_bins; ++to) events += events_in(bins_[to]);
    if (events >= fewest) continue;
    fewest = events;
    quietest = {from, to};
  }
  return quietest;
}

QuietStretch QuietMeter::quietest() const {
  const CameraTime begin = after(begin_, microseconds{bin_us * bins_[quietest_bins().first].index});
  return {begin, after(begin, reference)};
}

std::vector<bool> QuietMeter::moving() const {
  constexpr double deviations = 6, wander = 0.05;
  constexpr int most_rounds = 20;
  const std::int64_t end = bins_.back().index;  // the last bin is not full
  // At first only the bins of the 0.2 s with the fewest events are quiet.
  const auto [best_from, best_to] = quietest_bins();
  double bins = static_cast<double>(std::min(reference_bins, end + 1));
  std::vector<bool> moves(bins_.size(), true);
  std::fill(moves.begin() + static_cast<std::ptrdiff_t>(best_from), moves.begin() + static_cast<std::ptrdiff_t>(best_to), false);
  for (int round = 0; round < most_rounds; ++round) {
    std::array<double, std::tuple_size_v<Counts>> mean{};
    double squares = 0, variance = 0, all = 0;
    for (std::size_t i = 0; i < bins_.size(); ++i) {
      for (std::size_t part = 0; part < mean.size() && !moves[i]; ++part) {
        const double n = bins_[i].counts[part];
        mean[part] += n / bins;
        squares += n * n / bins;
      }
    }
    for (const double m : mean) {
      all += m;
      variance -= m * m;
    }
    const double dispersion = all > 0 ? std::max(1.0, (squares + variance) / all) : 1;
    std::vector<bool> now(bins_.size(), false);
    bins = static_cast<double>(end + 1);
    for (std::size_t i = 0; i < bins_.size(); ++i) {
      for (std::size_t part = 0; part < mean.size(); ++part) {
        const double m = mean[part], spread = std::sqrt(dispersion * m + wander * wander * m * m + 1);
        now[i] = now[i] || bins_[i].counts[part] > m + deviations * spread;
      }
      bins -= now[i] ? 1 : 0;
    }
    if (now == moves) break;
    moves = std::move(now);
  }
  return moves;
}

std::vector<QuietStretch> QuietMeter::stretches() const {
  std::vector<QuietStretch> stretches;
  if (bins_.empty()) return stretches;
  const std::vector<bool> moves = moving();
  const CameraTime end = after(last_, microseconds{1});
  CameraTime begin = first_;
  const auto take = [&](CameraTime until) {
    if (until > begin && between(begin, until) >= shortest) stretches.push_back({begin, until});
  };
  for (std::size_t i = 0; i < bins_.size(); ++i) {
    if (!moves[i]) continue;
    const CameraTime motion = after(begin_, microseconds{bin_us * bins_[i].index});
    take(after(motion, -margin));
    begin = after(motion, microseconds{bin_us} + margin);
  }
  take(end);
  return stretches;
}

}  // namespace tactile::characterise
