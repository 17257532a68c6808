#include "tactile/labels/lit_rate.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tactile/labels/brightening.hpp"
#include "tactile/labels/stretches.hpp"

namespace tactile::labels {
namespace {

constexpr std::int64_t never = std::int64_t{-1} << 40;

/// By cell, how many events it had in some stretch of time.
using CellCounts = std::vector<std::uint32_t>;

std::vector<bool> lit_cells(const CellCounts& burst, double burst_bins, const CellCounts& quiet, double quiet_bins,
                            double stands_out) {
  double quiet_events = 0;
  for (const std::uint32_t count : quiet) quiet_events += count;
  const double mean = quiet_events / static_cast<double>(quiet.size());
  std::vector<bool> lit(burst.size());
  for (std::size_t cell = 0; cell < burst.size(); ++cell) {
    // A cell's own count only if it is noisier than the mean: a cell that was quiet by chance is not quieter than others.
    const double noise = quiet_bins > 0 ? std::max<double>(quiet[cell], mean) * burst_bins / quiet_bins : 0.0;
    lit[cell] = burst[cell] > noise + stands_out * std::sqrt(noise) + 4.0;
  }
  return lit;
}

constexpr int no_place = -1;

/// By cell the place that it belongs to: connected lit cells with at least `least` events above the noise together, the strongest
/// first.
struct Places {
  std::vector<int> of_cell;
  std::size_t count = 0;
};

Places places_of(const ImageCells& cells, const std::vector<bool>& lit, const CellCounts& burst, double burst_bins,
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
          const auto next = static_cast<std::size_t>(v) * static_cast<std::size_t>(cells.columns()) + static_cast<std::size_t>(u);
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

/// Variance per mean of sums over `width` bins before the burst, from successive differences: a slow change is no clump.
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

/// Of a burst that no single cell shows: those of every 3 x 3 cells that stand out together.
std::vector<bool> faintly_lit_cells(const ImageCells& cells, const CellCounts& burst, double burst_bins, const CellCounts& quiet,
                                    double quiet_bins, double stands_out) {
  double mean = 0;
  for (const std::uint32_t count : quiet) mean += count / static_cast<double>(quiet.size());
  std::vector<bool> lit(burst.size());
  const auto columns = static_cast<std::size_t>(cells.columns()), rows = static_cast<std::size_t>(cells.rows());
  for (std::size_t row = 1; row + 1 < rows; ++row) {
    for (std::size_t column = 1; column + 1 < columns; ++column) {
      double events = 0, noise = 0;
      const auto for_all = [&](const auto& use) {
        for (std::size_t v = row - 1; v <= row + 1; ++v)
          for (std::size_t u = column - 1; u <= column + 1; ++u) use(v * columns + u);
      };
      for_all([&](std::size_t cell) {
        events += burst[cell];
        noise += quiet_bins > 0 ? std::max<double>(quiet[cell], mean) * burst_bins / quiet_bins : 0.0;
      });
      if (events > noise + stands_out * std::sqrt(noise) + 4.0) for_all([&](std::size_t cell) { lit[cell] = true; });
    }
  }
  return lit;
}

/// Finds the rates of all bursts together, for each pass over the recording serves all of them.
class LitRates {
 public:
  LitRates(events::RecordingReader& recording, std::int32_t stream_id, const alignment::EventRate& rate,
           std::span<const alignment::Burst> bursts, const LitRateOptions& options)
      : recording_(recording),
        stream_id_(stream_id),
        rate_(rate),
        bursts_(bursts),
        options_(options),
        size_(*recording.stream(stream_id).size),
        cells_(size_, options.cell_px),
        is_quiet_(rate.counts.size(), true),
        quiet_(cells_.count()),
        of_burst_(bursts.size(), CellCounts(cells_.count())),
        brighter_(bursts.size(), Brightening(cells_.count())) {}

  std::vector<LitRate> find() {
    set_windows();
    count_cells();
    Brightening so_far(cells_.count());
    for (std::size_t i = 0; i < bursts_.size(); ++i) {
      add_rate(i);
      if (std::find(options_.fresh_at.begin(), options_.fresh_at.end(), i) != options_.fresh_at.end())
        std::fill(so_far.begin(), so_far.end(), 0);
      rates_[i].undoes = -correlation_of(brighter_[i], so_far);
      add(so_far, brighter_[i]);
    }
    count_events();
    for (std::size_t i = 0; i < bursts_.size(); ++i) set_dispersions(i);
    return std::move(rates_);
  }

 private:
  std::size_t bins(microseconds span) const { return static_cast<std::size_t>(span / rate_.bin); }

  void set_windows() {
    const std::size_t bin_count = rate_.counts.size();
    for (std::size_t i = 0; i < bursts_.size(); ++i) {
      const alignment::Burst& burst = bursts_[i];
      const auto around = [&](std::size_t margin) {
        return Stretch{burst.begin - std::min(burst.begin, margin), std::min(bin_count, burst.end + margin)};
      };
      const Stretch loud = around(bins(options_.quiet_margin));
      std::fill(is_quiet_.begin() + static_cast<std::ptrdiff_t>(loud.begin),
                is_quiet_.begin() + static_cast<std::ptrdiff_t>(loud.end), false);
      // Without the events of other bursts.
      Stretch window = around(bins(options_.margin));
      if (i > 0) window.begin = std::max(window.begin, std::min(bursts_[i - 1].end, burst.begin));
      if (i + 1 < bursts_.size()) window.end = std::min(window.end, std::max(bursts_[i + 1].begin, burst.end));
      windows_.push_back(window);
    }
    quiet_bins_ = static_cast<double>(std::count(is_quiet_.begin(), is_quiet_.end(), true));
  }

  /// In which cells each burst has its events.
  void count_cells() {
    std::vector<Stretch> spans;
    for (const alignment::Burst& burst : bursts_) spans.push_back({burst.begin, burst.end});
    Stretches near(spans);
    alignment::for_counted_events(recording_, stream_id_, rate_, [&](const events::Event& event, std::size_t bin) {
      if (is_quiet_[bin]) ++quiet_[cells_.at(event)];
      const Stretch candidates = near.around(bin);
      for (std::size_t i = candidates.begin; i < candidates.end; ++i) {
        if (bin < bursts_[i].begin || bin >= bursts_[i].end) continue;
        const std::size_t cell = cells_.at(event);
        ++of_burst_[i][cell];
        brighter_[i][cell] += event.on != 0 ? 1 : -1;
      }
    });
  }

  /// All of a burst's rate but the counts.
  void add_rate(std::size_t i) {
    const alignment::Burst& burst = bursts_[i];
    const auto burst_bins = static_cast<double>(burst.end - burst.begin);
    std::vector<bool>& lit = lit_.emplace_back(
        burst.slow ? faintly_lit_cells(cells_, of_burst_[i], burst_bins, quiet_, quiet_bins_, options_.stands_out)
                   : lit_cells(of_burst_[i], burst_bins, quiet_, quiet_bins_, options_.stands_out));
    // A burst that no place of the image explains, such as a flicker, has the whole image.
    if (std::none_of(lit.begin(), lit.end(), [](bool is_lit) { return is_lit; })) lit.assign(cells_.count(), true);
    const Places& places = places_.emplace_back(places_of(cells_, lit, of_burst_[i], burst_bins, quiet_, quiet_bins_, options_));
    LitRate& found = rates_.emplace_back();
    const std::size_t length = windows_[i].end - windows_[i].begin;
    found.rate.begin = rate_.begin_of(windows_[i].begin);
    found.rate.bin = rate_.bin;
    found.rate.counts.resize(length);
    found.rate.hot_pixels = rate_.hot_pixels;
    found.rate.last = std::min(rate_.last, rate_.begin_of(windows_[i].end));
    found.repeats.resize(length);
    found.burst_begin = burst.begin - windows_[i].begin;
    found.burst_end = burst.end - windows_[i].begin;
    LitPlace empty;
    empty.counts.resize(length);
    empty.repeats.resize(length);
    found.places.assign(places.count, empty);
    double quiet_events = 0, lit_count = 0;
    for (std::size_t cell = 0; cell < cells_.count(); ++cell) {
      if (const int place = places.of_cell[cell]; place != no_place && quiet_bins_ > 0)
        found.places[static_cast<std::size_t>(place)].quiet_per_bin += quiet_[cell] / quiet_bins_;
      if (!lit[cell]) continue;
      quiet_events += quiet_[cell];
      lit_count += 1;
    }
    found.quiet_per_bin = quiet_bins_ > 0 ? quiet_events / quiet_bins_ : 0.0;
    const std::size_t still_from = i > 0 ? std::min(bursts_[i - 1].end, burst.begin) : 0;
    const double pixels = std::max(1.0, lit_count * options_.cell_px * options_.cell_px);
    found.reset_share = 1.0 - std::exp(-found.quiet_per_bin * static_cast<double>(burst.begin - still_from) / pixels);
    found.lit_share = lit_count / static_cast<double>(cells_.count());
  }

  void count_events() {
    // By pixel the bin and polarity of its last event: 2 * bin + on.
    std::vector<std::int64_t> last_of(static_cast<std::size_t>(size_.width) * static_cast<std::size_t>(size_.height), never);
    const auto repeat_bins = static_cast<std::int64_t>(bins(options_.repeat_within));
    Stretches near(windows_);
    alignment::for_counted_events(recording_, stream_id_, rate_, [&](const events::Event& event, std::size_t bin) {
      std::int64_t& last =
          last_of[static_cast<std::size_t>(event.y) * static_cast<std::size_t>(size_.width) + static_cast<std::size_t>(event.x)];
      const std::int64_t now = 2 * static_cast<std::int64_t>(bin) + event.on;
      const bool repeats = (now - last) % 2 == 0 && now > last && now - last <= 2 * repeat_bins;
      last = now;
      const std::size_t cell = cells_.at(event);
      const Stretch candidates = near.around(bin);
      for (std::size_t i = candidates.begin; i < candidates.end; ++i) {
        if (!windows_[i].holds(bin) || !lit_[i][cell]) continue;
        const std::size_t at = bin - windows_[i].begin;
        ++rates_[i].rate.counts[at];
        if (repeats) ++rates_[i].repeats[at];
        const int which = places_[i].of_cell[cell];
        if (which == no_place) continue;
        LitPlace& place = rates_[i].places[static_cast<std::size_t>(which)];
        ++place.counts[at];
        if (repeats) ++place.repeats[at];
      }
    });
  }

  /// Before the burst, as far as there is no other.
  void set_dispersions(std::size_t i) {
    const std::size_t loud = bursts_[i].begin - std::min(bursts_[i].begin, bins(options_.quiet_margin));
    std::size_t from = loud;
    while (from > windows_[i].begin && is_quiet_[from - 1]) --from;
    const auto dispersion_before = [&](std::span<const std::uint32_t> counts) {
      return dispersion_of(counts.subspan(from - windows_[i].begin, loud - from), std::max<std::size_t>(1, bins(5ms)));
    };
    rates_[i].dispersion = dispersion_before(rates_[i].rate.counts);
    for (LitPlace& place : rates_[i].places) place.dispersion = dispersion_before(place.counts);
  }

  events::RecordingReader& recording_;
  std::int32_t stream_id_;
  const alignment::EventRate& rate_;
  std::span<const alignment::Burst> bursts_;
  const LitRateOptions& options_;
  events::SensorSize size_;
  ImageCells cells_;
  std::vector<bool> is_quiet_;  ///< by bin
  double quiet_bins_ = 0;
  CellCounts quiet_;              ///< of the quiet bins
  std::vector<Stretch> windows_;  ///< by burst, as are the following
  std::vector<CellCounts> of_burst_;
  std::vector<Brightening> brighter_;
  std::vector<std::vector<bool>> lit_;
  std::vector<Places> places_;
  std::vector<LitRate> rates_;
};

}  // namespace

std::vector<LitRate> lit_rates(events::RecordingReader& recording, std::int32_t stream_id, const alignment::EventRate& rate,
                               std::span<const alignment::Burst> bursts, const LitRateOptions& options) {
  if (bursts.empty()) return {};
  return LitRates(recording, stream_id, rate, bursts, options).find();
}

}  // namespace tactile::labels
