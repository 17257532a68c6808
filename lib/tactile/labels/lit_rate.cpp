#include "tactile/labels/lit_rate.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tactile {
namespace {

constexpr std::int64_t never = std::int64_t{-1} << 40;

/// By cell, how many events it had in some stretch of time.
using CellCounts = std::vector<std::uint32_t>;

/// By cell, how many more events were brighter than darker.
using Brightening = std::vector<std::int32_t>;

/// About 0, not about the means: no brightening is no likeness.
double correlation_of(const Brightening& a, const Brightening& b) {
  double aa = 0, bb = 0, ab = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    aa += static_cast<double>(a[i]) * a[i];
    bb += static_cast<double>(b[i]) * b[i];
    ab += static_cast<double>(a[i]) * b[i];
  }
  return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0.0;
}

class Cells {
 public:
  Cells(SensorSize size, int cell_px)
      : cell_px_(cell_px), columns_((size.width + cell_px - 1) / cell_px), rows_((size.height + cell_px - 1) / cell_px) {}
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  std::size_t count() const { return static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_); }
  std::size_t at(const Event& event) const {
    return static_cast<std::size_t>(event.y / cell_px_) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(event.x / cell_px_);
  }

 private:
  int cell_px_, columns_, rows_;
};

/// A stretch of bins of the whole recording, [begin, end).
struct Stretch {
  std::size_t begin = 0, end = 0;
  bool holds(std::size_t bin) const { return bin >= begin && bin < end; }
};

std::vector<bool> lit_cells(const CellCounts& burst, double burst_bins, const CellCounts& quiet, double quiet_bins,
                            double stands_out) {
  double quiet_events = 0;
  for (const std::uint32_t count : quiet) quiet_events += count;
  const double mean = quiet_events / static_cast<double>(quiet.size());
  std::vector<bool> lit(burst.size());
  for (std::size_t cell = 0; cell < burst.size(); ++cell) {
    // A cell's own count where it is noisier than the mean, for one that was quiet by chance is no quieter than others.
    const double noise = quiet_bins > 0 ? std::max<double>(quiet[cell], mean) * burst_bins / quiet_bins : 0.0;
    lit[cell] = burst[cell] > noise + stands_out * std::sqrt(noise) + 4.0;
  }
  return lit;
}

constexpr int no_place = -1;

/// By cell the place that it belongs to: those of the lit cells that hang together and have at least `least` events above the
/// noise together, the strongest first.
struct Places {
  std::vector<int> of_cell;
  std::size_t count = 0;
};

Places places_of(const Cells& cells, const std::vector<bool>& lit, const CellCounts& burst, double burst_bins,
                 const CellCounts& quiet, double quiet_bins, const LitRateOptions& options) {
  constexpr double least = 40.0;
  std::vector<int> group(cells.count(), no_place);
  std::vector<std::pair<double, int>> events;  // above the noise, of each group
  std::vector<std::size_t> open;
  for (std::size_t seed = 0; seed < lit.size(); ++seed) {
    if (!lit[seed] || group[seed] != no_place) continue;
    const int here = static_cast<int>(events.size());
    double sum = 0;
    group[seed] = here;
    open.push_back(seed);
    while (!open.empty()) {
      const std::size_t cell = open.back();
      open.pop_back();
      sum += burst[cell] - (quiet_bins > 0 ? quiet[cell] * burst_bins / quiet_bins : 0.0);
      const int column = static_cast<int>(cell) % cells.columns(), row = static_cast<int>(cell) / cells.columns();
      const int reach = options.joined_cells;
      for (int v = std::max(0, row - reach); v <= std::min(cells.rows() - 1, row + reach); ++v) {
        for (int u = std::max(0, column - reach); u <= std::min(cells.columns() - 1, column + reach); ++u) {
          const auto next = static_cast<std::size_t>(v * cells.columns() + u);
          if (!lit[next] || group[next] != no_place) continue;
          group[next] = here;
          open.push_back(next);
        }
      }
    }
    events.emplace_back(-sum, here);
  }
  std::sort(events.begin(), events.end());
  std::vector<int> place_of_group(events.size(), no_place);
  Places places;
  for (const auto& [less, which] : events) {
    if (-less < least || places.count >= options.most_places) break;
    place_of_group[static_cast<std::size_t>(which)] = static_cast<int>(places.count++);
  }
  for (int& cell : group) cell = cell == no_place ? no_place : place_of_group[static_cast<std::size_t>(cell)];
  places.of_cell = std::move(group);
  return places;
}

/// Variance per mean of sums over `width` bins ahead of the burst, from successive differences: a slow change is no clump.
double dispersion_of(std::span<const std::uint32_t> counts, std::size_t width) {
  std::vector<double> sums;
  for (std::size_t begin = 0; begin + width <= counts.size(); begin += width) {
    double sum = 0;
    for (std::size_t i = begin; i < begin + width; ++i) sum += counts[i];
    sums.push_back(sum);
  }
  double squares = 0, total = 0;
  for (std::size_t i = 0; i + 1 < sums.size(); ++i) squares += (sums[i + 1] - sums[i]) * (sums[i + 1] - sums[i]);
  for (const double sum : sums) total += sum;
  if (sums.size() < 10 || !(total > 0)) return 1.0;
  const double n = static_cast<double>(sums.size());
  return std::max(1.0, squares / (2.0 * (n - 1.0)) / (total / n));
}

}  // namespace

std::vector<LitRate> lit_rates(RecordingReader& recording, std::int32_t stream_id, const EventRate& rate,
                               std::span<const Burst> bursts, const LitRateOptions& options) {
  if (bursts.empty()) return {};
  const SensorSize size = *recording.stream(stream_id).size;
  const Cells cells(size, options.cell_px);
  const auto bins = [&](microseconds span) { return static_cast<std::size_t>(span / rate.bin); };
  const std::size_t bin_count = rate.counts.size();

  std::vector<bool> is_quiet(bin_count, true);
  std::vector<Stretch> windows;
  for (std::size_t i = 0; i < bursts.size(); ++i) {
    const Burst& burst = bursts[i];
    const auto around = [&](std::size_t margin) {
      return Stretch{burst.begin - std::min(burst.begin, margin), std::min(bin_count, burst.end + margin)};
    };
    const Stretch loud = around(bins(options.quiet_margin));
    std::fill(is_quiet.begin() + static_cast<std::ptrdiff_t>(loud.begin),
              is_quiet.begin() + static_cast<std::ptrdiff_t>(loud.end), false);
    // What another burst did is none of this one's.
    Stretch window = around(bins(options.margin));
    if (i > 0) window.begin = std::max(window.begin, std::min(bursts[i - 1].end, burst.begin));
    if (i + 1 < bursts.size()) window.end = std::min(window.end, std::max(bursts[i + 1].begin, burst.end));
    windows.push_back(window);
  }
  const auto quiet_bins = static_cast<double>(std::count(is_quiet.begin(), is_quiet.end(), true));

  // In which cells each burst has its events.
  CellCounts quiet(cells.count());
  std::vector<CellCounts> of_burst(bursts.size(), CellCounts(cells.count()));
  std::vector<Brightening> brighter(bursts.size(), Brightening(cells.count()));
  for_counted_events(recording, stream_id, rate, [&](const Event& event, std::size_t bin) {
    if (is_quiet[bin]) ++quiet[cells.at(event)];
    for (std::size_t i = 0; i < bursts.size(); ++i) {
      if (bin >= bursts[i].begin && bin < bursts[i].end) {
        const std::size_t cell = cells.at(event);
        ++of_burst[i][cell];
        brighter[i][cell] += event.on != 0 ? 1 : -1;
      }
    }
  });
  Brightening so_far(cells.count());
  std::vector<std::vector<bool>> lit;
  std::vector<Places> places;
  std::vector<LitRate> rates;
  for (std::size_t i = 0; i < bursts.size(); ++i) {
    const auto burst_bins = static_cast<double>(bursts[i].end - bursts[i].begin);
    lit.push_back(lit_cells(of_burst[i], burst_bins, quiet, quiet_bins, options.stands_out));
    // A burst that no place of the image explains, such as a flicker, is taken whole.
    if (std::none_of(lit[i].begin(), lit[i].end(), [](bool is_lit) { return is_lit; })) lit[i].assign(cells.count(), true);
    places.push_back(places_of(cells, lit[i], of_burst[i], burst_bins, quiet, quiet_bins, options));
    LitRate found;
    found.rate = {.begin = rate.begin_of(windows[i].begin),
                  .bin = rate.bin,
                  .counts = std::vector<std::uint32_t>(windows[i].end - windows[i].begin),
                  .hot_pixels = rate.hot_pixels,
                  .last = std::min(rate.last, rate.begin_of(windows[i].end)),
                  .hot = {},
                  .saturated_bins = 0,
                  .flicker_hz = {}};
    found.repeats.resize(found.rate.counts.size());
    found.burst_begin = bursts[i].begin - windows[i].begin;
    found.burst_end = bursts[i].end - windows[i].begin;
    found.places.resize(places[i].count);
    for (LitPlace& place : found.places) {
      place.counts.resize(found.rate.counts.size());
      place.repeats.resize(found.rate.counts.size());
    }
    double quiet_events = 0, lit_count = 0;
    for (std::size_t cell = 0; cell < cells.count(); ++cell) {
      if (const int place = places[i].of_cell[cell]; place != no_place && quiet_bins > 0)
        found.places[static_cast<std::size_t>(place)].quiet_per_bin += quiet[cell] / quiet_bins;
      if (!lit[i][cell]) continue;
      quiet_events += quiet[cell];
      lit_count += 1;
    }
    found.quiet_per_bin = quiet_bins > 0 ? quiet_events / quiet_bins : 0.0;
    const std::size_t still_from = i > 0 ? std::min(bursts[i - 1].end, bursts[i].begin) : 0;
    const double pixels = std::max(1.0, lit_count * options.cell_px * options.cell_px);
    found.set_anew = 1.0 - std::exp(-found.quiet_per_bin * static_cast<double>(bursts[i].begin - still_from) / pixels);
    found.lit_share = lit_count / static_cast<double>(cells.count());
    found.undoes = -correlation_of(brighter[i], so_far);
    for (std::size_t cell = 0; cell < cells.count(); ++cell) so_far[cell] += brighter[i][cell];
    rates.push_back(std::move(found));
  }
  // By pixel the bin and polarity of its last event: 2 * bin + on.
  std::vector<std::int64_t> last_of(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height), never);
  const auto repeat_bins = static_cast<std::int64_t>(bins(options.repeat_within));
  for_counted_events(recording, stream_id, rate, [&](const Event& event, std::size_t bin) {
    std::int64_t& last =
        last_of[static_cast<std::size_t>(event.y) * static_cast<std::size_t>(size.width) + static_cast<std::size_t>(event.x)];
    const std::int64_t now = 2 * static_cast<std::int64_t>(bin) + event.on;
    const bool repeats = (now - last) % 2 == 0 && now > last && now - last <= 2 * repeat_bins;
    last = now;
    for (std::size_t i = 0; i < bursts.size(); ++i) {
      const std::size_t cell = cells.at(event);
      if (!windows[i].holds(bin) || !lit[i][cell]) continue;
      const std::size_t at = bin - windows[i].begin;
      ++rates[i].rate.counts[at];
      if (repeats) ++rates[i].repeats[at];
      const int which = places[i].of_cell[cell];
      if (which == no_place) continue;
      LitPlace& place = rates[i].places[static_cast<std::size_t>(which)];
      ++place.counts[at];
      if (repeats) ++place.repeats[at];
    }
  });
  for (std::size_t i = 0; i < bursts.size(); ++i) {
    // Ahead of the burst, as far as nothing else was on.
    const auto loud = static_cast<std::ptrdiff_t>(bursts[i].begin - std::min(bursts[i].begin, bins(options.quiet_margin)));
    auto from = loud;
    while (from > static_cast<std::ptrdiff_t>(windows[i].begin) && is_quiet[static_cast<std::size_t>(from - 1)]) --from;
    const auto dispersion_ahead = [&](std::span<const std::uint32_t> counts) {
      const auto ahead = counts.subspan(static_cast<std::size_t>(from) - windows[i].begin, static_cast<std::size_t>(loud - from));
      return dispersion_of(ahead, std::max<std::size_t>(1, bins(5ms)));
    };
    rates[i].dispersion = dispersion_ahead(rates[i].rate.counts);
    for (LitPlace& place : rates[i].places) place.dispersion = dispersion_ahead(place.counts);
  }
  return rates;
}

}  // namespace tactile
