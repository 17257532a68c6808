#include "tactile/alignment/slow_bursts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>

namespace tactile::alignment {
namespace {

constexpr std::array<std::size_t, 3> window_slots{2, 6, 20};
constexpr double least_events = 10.0;

using CellCounts = std::vector<std::uint32_t>;

/// The image in cells.
struct Grid {
  std::size_t columns = 0, rows = 0, cell_px = 1;

  Grid(events::SensorSize size, int px)
      : columns((static_cast<std::size_t>(size.width) + static_cast<std::size_t>(px) - 1) / static_cast<std::size_t>(px)),
        rows((static_cast<std::size_t>(size.height) + static_cast<std::size_t>(px) - 1) / static_cast<std::size_t>(px)),
        cell_px(static_cast<std::size_t>(px)) {}
  std::size_t cells() const { return columns * rows; }
  std::size_t at(const events::Event& event) const {
    return static_cast<std::size_t>(event.y) / cell_px * columns + static_cast<std::size_t>(event.x) / cell_px;
  }
  /// Calls `use` with each cell of the 3 x 3 around one.
  template <class Use>
  void around(std::size_t cell, Use&& use) const {
    const std::size_t column = cell % columns, row = cell / columns;
    for (std::size_t v = row - std::min<std::size_t>(row, 1); v <= std::min(rows - 1, row + 1); ++v)
      for (std::size_t u = column - std::min<std::size_t>(column, 1); u <= std::min(columns - 1, column + 1); ++u)
        use(v * columns + u);
  }
};

/// Finds rises slot by slot while the recording is read.
class RiseSearch {
 public:
  RiseSearch(const Grid& grid, std::vector<double> noise_per_slot, const SlowBurstOptions& options)
      : grid_(grid), noise_(std::move(noise_per_slot)), options_(options) {
    for (const double noise : noise_) all_noise_ += noise;
    for (CellCounts& sum : sums_) sum.resize(grid_.cells());
  }

  /// The counts of the next slot. @param usable  it lies outside all bursts
  void add(CellCounts counts, bool usable) {
    ++slot_;
    if (!usable) {
      kept_.clear();
      for (CellCounts& sum : sums_) std::fill(sum.begin(), sum.end(), 0U);
      return;
    }
    kept_.push_back(std::move(counts));
    for (std::size_t w = 0; w < window_slots.size(); ++w) {
      const bool full = kept_.size() > window_slots[w];
      const CellCounts& newest = kept_.back();
      for (std::size_t cell = 0; cell < newest.size(); ++cell)
        sums_[w][cell] += newest[cell] - (full ? kept_[kept_.size() - 1 - window_slots[w]][cell] : 0U);
      if (kept_.size() >= window_slots[w]) look(w);
    }
    if (kept_.size() > window_slots.back()) kept_.pop_front();
  }

  /// Slots with a rise, [begin, end), by begin.
  std::vector<std::pair<std::size_t, std::size_t>> found;

 private:
  /// The window that ends with the newest slot.
  void look(std::size_t w) {
    const auto length = static_cast<double>(window_slots[w]);
    double all = 0;
    for (const std::uint32_t count : sums_[w]) all += count;
    const double brighter = std::max(1.0, all / std::max(1.0, all_noise_ * length));
    std::vector<bool> rises(grid_.cells());
    bool any = false;
    for (std::size_t cell = 0; cell < grid_.cells(); ++cell) {
      if (sums_[w][cell] == 0) continue;
      double count = 0, noise = 0;
      grid_.around(cell, [&](std::size_t near) {
        count += sums_[w][near];
        noise += noise_[near];
      });
      noise *= length * brighter;
      if (count < noise + options_.stands_out * std::sqrt(options_.dispersion * noise) + least_events) continue;
      grid_.around(cell, [&](std::size_t near) { rises[near] = true; });
      any = true;
    }
    if (any) add_slots(rises, window_slots[w], brighter);
  }

  /// The slots of the window in which the cells that rise have more than their noise.
  void add_slots(const std::vector<bool>& rises, std::size_t length, double brighter) {
    double noise = 0;
    for (std::size_t cell = 0; cell < rises.size(); ++cell) noise += rises[cell] ? noise_[cell] * brighter : 0.0;
    const double limit = noise + 2.0 * std::sqrt(options_.dispersion * std::max(noise, 1.0));
    std::size_t first = length, last = 0;
    for (std::size_t i = 0; i < length; ++i) {
      const CellCounts& slot = kept_[kept_.size() - length + i];
      double count = 0;
      for (std::size_t cell = 0; cell < rises.size(); ++cell) count += rises[cell] ? slot[cell] : 0U;
      if (count < limit) continue;
      first = std::min(first, i);
      last = i + 1;
    }
    if (first < last) found.emplace_back(slot_ - length + first, slot_ - length + last);
  }

  const Grid& grid_;
  std::vector<double> noise_;
  const SlowBurstOptions& options_;
  double all_noise_ = 0;
  std::size_t slot_ = 0;  ///< slots so far
  std::deque<CellCounts> kept_;
  std::array<CellCounts, window_slots.size()> sums_;
};

/// Hands each event that counts, its cell and its slot to `use`, in file order.
template <class Use>
void for_limited_events(events::RecordingReader& recording, std::int32_t stream_id, const EventRate& rate, std::size_t slot_bins,
                        unsigned most_per_pixel, Use&& use) {
  const events::SensorSize size = *recording.stream(stream_id).size;
  const auto width = static_cast<std::size_t>(size.width);
  struct InSlot {
    std::uint32_t slot = 0, events = 0;
  };
  std::vector<InSlot> pixels(width * static_cast<std::size_t>(size.height));
  for_counted_events(recording, stream_id, rate, [&](const events::Event& event, std::size_t bin) {
    InSlot& pixel = pixels[static_cast<std::size_t>(event.y) * width + static_cast<std::size_t>(event.x)];
    const auto slot = static_cast<std::uint32_t>(bin / slot_bins);
    if (pixel.slot != slot) pixel = {slot, 0};
    if (++pixel.events <= most_per_pixel) use(event, slot);
  });
}

/// By slot, whether it lies outside the bursts and their decline.
std::vector<bool> usable_slots(const EventRate& rate, std::span<const Burst> known, std::size_t slot_bins,
                               std::size_t fade_bins) {
  std::vector<bool> usable(rate.counts.size() / slot_bins, true);
  for (const Burst& burst : known) {
    for (std::size_t slot = burst.begin / slot_bins; slot < usable.size() && slot * slot_bins < burst.end + fade_bins; ++slot)
      usable[slot] = false;
  }
  return usable;
}

/// Events of each cell in a slot, on average over the usable ones.
std::vector<double> noise_of(events::RecordingReader& recording, std::int32_t stream_id, const EventRate& rate, const Grid& grid,
                             const std::vector<bool>& usable, std::size_t slot_bins, unsigned most_per_pixel) {
  std::vector<double> noise(grid.cells());
  for_limited_events(recording, stream_id, rate, slot_bins, most_per_pixel, [&](const events::Event& event, std::size_t slot) {
    if (slot < usable.size() && usable[slot]) noise[grid.at(event)] += 1.0;
  });
  const auto slots = static_cast<double>(std::max<std::ptrdiff_t>(1, std::count(usable.begin(), usable.end(), true)));
  double mean = 0;
  for (double& of_cell : noise) {
    of_cell /= slots;
    mean += of_cell / static_cast<double>(noise.size());
  }
  // A cell that was quiet by chance is no quieter than others.
  for (double& of_cell : noise) of_cell = std::max(of_cell, mean);
  return noise;
}

}  // namespace

std::vector<Burst> slow_bursts(events::RecordingReader& recording, std::int32_t stream_id, const EventRate& rate,
                               std::span<const Burst> known, const SlowBurstOptions& options) {
  const auto bins = [&](microseconds span) { return static_cast<std::size_t>(std::max<std::int64_t>(1, span / rate.bin)); };
  const std::size_t slot_bins = bins(options.slot);
  const std::vector<bool> usable = usable_slots(rate, known, slot_bins, bins(options.fades_within));
  const Grid grid(*recording.stream(stream_id).size, options.cell_px);
  RiseSearch search(grid, noise_of(recording, stream_id, rate, grid, usable, slot_bins, options.most_per_pixel), options);
  CellCounts counts(grid.cells());
  std::size_t slot = 0;
  const auto finish_until = [&](std::size_t until) {
    for (; slot < std::min(until, usable.size()); ++slot) {
      search.add(counts, usable[slot]);
      std::fill(counts.begin(), counts.end(), 0U);
    }
  };
  for_limited_events(recording, stream_id, rate, slot_bins, options.most_per_pixel,
                     [&](const events::Event& event, std::size_t in) {
                       finish_until(in);
                       if (in == slot) ++counts[grid.at(event)];
                     });
  finish_until(usable.size());

  std::sort(search.found.begin(), search.found.end());
  std::vector<Burst> bursts;
  for (const auto& [first, last] : search.found) {
    const Burst burst{.begin = first * slot_bins, .end = last * slot_bins, .slow = true};
    if (!bursts.empty() && burst.begin <= bursts.back().end + slot_bins) {
      bursts.back().end = std::max(bursts.back().end, burst.end);
    } else {
      bursts.push_back(burst);
    }
  }
  return bursts;
}

}  // namespace tactile::alignment
