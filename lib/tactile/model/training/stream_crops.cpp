#include "tactile/model/training/stream_crops.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/parallel.hpp"

namespace tactile::model {
namespace {

using Layout = StreamLayout;
using Image = StreamImage;
constexpr std::size_t pixels = Image::size;

/// A number in [low, high].
std::size_t within(Random& random, std::size_t low, std::size_t high) { return low + random.below(high - low + 1); }

bool happens(Random& random, double probability) { return random.uniform() < probability; }

std::uint8_t thinned(std::uint8_t count, double kept, Random& random) {
  std::uint8_t left = 0;
  for (std::uint8_t i = 0; i < count; ++i) {
    if (happens(random, kept)) ++left;
  }
  return left;
}

/// Changes where the counts of every tick lie.
/// @param from  of each pixel of the image, the one that its count comes from
void move_pixels(std::vector<std::uint8_t>& counts, const std::array<std::size_t, pixels>& from) {
  std::array<std::uint8_t, pixels> tick{};
  for (std::size_t first = 0; first < counts.size(); first += pixels) {
    std::copy_n(counts.begin() + static_cast<std::ptrdiff_t>(first), pixels, tick.begin());
    for (std::size_t i = 0; i < pixels; ++i) counts[first + i] = tick[from[i]];
  }
}

struct Moved {
  bool mirrored_in_x, mirrored_in_y;
  std::size_t rows, columns;  ///< by which all moves, around
};

std::array<std::size_t, pixels> sources_of(const Moved& moved) {
  std::array<std::size_t, pixels> from{};
  for (std::size_t polarity = 0; polarity < 2; ++polarity) {
    for (std::size_t row = 0; row < Image::rows; ++row) {
      for (std::size_t column = 0; column < Image::columns; ++column) {
        const std::size_t y = (row + moved.rows) % Image::rows, x = (column + moved.columns) % Image::columns;
        from[Image::at(polarity, row, column)] =
            Image::at(polarity, moved.mirrored_in_y ? Image::rows - 1 - y : y, moved.mirrored_in_x ? Image::columns - 1 - x : x);
      }
    }
  }
  return from;
}

/// ON and OFF exchanged.
std::array<std::size_t, pixels> exchanged_polarities() {
  std::array<std::size_t, pixels> from{};
  for (std::size_t i = 0; i < pixels; ++i) from[i] = (i + pixels / 2) % pixels;
  return from;
}

std::vector<std::uint8_t> counts_of(const StreamRun& run, std::size_t begin, std::size_t end) {
  return {run.counts.begin() + static_cast<std::ptrdiff_t>(begin * pixels),
          run.counts.begin() + static_cast<std::ptrdiff_t>(end * pixels)};
}

void reverse_ticks(std::vector<std::uint8_t>& counts) {
  for (std::size_t low = 0, high = counts.size() / pixels; low + 1 < high; ++low, --high) {
    const auto at = [&](std::size_t tick) { return counts.begin() + static_cast<std::ptrdiff_t>(tick * pixels); };
    std::swap_ranges(at(low), at(low + 1), at(high - 1));
  }
}

/// Motion of a part of the skin is made in patches, a quarter of a place each.
constexpr std::size_t patches_across = 2 * Layout::across, patches = 2 * Layout::down * patches_across;

std::size_t patch_of(std::size_t pixel) {
  const std::size_t row = pixel / Image::columns % Image::rows, column = pixel % Image::columns;
  return row / (Layout::rows / 2) * patches_across + column / (Image::columns / patches_across);
}

/// The pixels of a patch, ascending.
const std::vector<std::size_t>& pixels_of(std::size_t patch) {
  static const std::array<std::vector<std::size_t>, patches> of_patch = [] {
    std::array<std::vector<std::size_t>, patches> lists;
    for (std::size_t pixel = 0; pixel < pixels; ++pixel) lists[patch_of(pixel)].push_back(pixel);
    return lists;
  }();
  return of_patch[patch];
}

/// @param from  a whole number of ticks; where it is shorter than `to`, it comes again and again
void copy_patch(std::span<const std::uint8_t> from, std::span<std::uint8_t> to, std::size_t patch) {
  for (std::size_t first = 0; first < to.size(); first += pixels) {
    const std::size_t source = first % from.size();
    for (const std::size_t pixel : pixels_of(patch)) to[first + pixel] = from[source + pixel];
  }
}

/// The patches, those with the most events first.
std::array<std::size_t, patches> by_events(std::span<const std::uint8_t> counts) {
  std::array<std::uint64_t, patches> events{};
  for (std::size_t patch = 0; patch < patches; ++patch) {
    for (std::size_t first = 0; first < counts.size(); first += pixels) {
      for (const std::size_t pixel : pixels_of(patch)) events[patch] += counts[first + pixel];
    }
  }
  std::array<std::size_t, patches> order{};
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return events[a] > events[b]; });
  return order;
}

/// The same motion at another speed: the events of a tick come in one tick each, or in two by chance.
/// @param speed  > 0; the ticks that a faster piece lacks at its end weigh 0
void change_speed(std::vector<std::uint8_t>& counts, std::vector<Touch>& truth, std::vector<float>& weights, double speed,
                  Random& random) {
  const std::size_t ticks = truth.size();
  std::vector<std::uint8_t> changed(counts.size());
  std::vector<Touch> new_truth(ticks, Touch::none);
  std::vector<float> new_weights(ticks, 0.0F);
  const auto at = [speed](std::size_t tick) { return static_cast<std::size_t>(static_cast<double>(tick) / speed); };
  for (std::size_t k = 0; k < ticks && at(k) < ticks; ++k) {
    const std::size_t to = at(k), last = std::min(ticks - 1, std::max(to, at(k + 1) - 1));
    for (std::size_t i = 0; i < pixels; ++i) {
      const std::uint8_t count = counts[k * pixels + i];
      if (count == 0) continue;
      const std::uint8_t later = to == last ? std::uint8_t{0} : thinned(count, 0.5, random);
      const auto add = [&](std::size_t tick, unsigned more) {
        std::uint8_t& sum = changed[tick * pixels + i];
        sum = static_cast<std::uint8_t>(std::min(255U, sum + more));
      };
      add(to, count - later);
      add(last, later);
    }
    for (std::size_t tick = to; tick <= last; ++tick) new_truth[tick] = truth[k], new_weights[tick] = weights[k];
  }
  counts = std::move(changed);
  truth = std::move(new_truth);
  weights = std::move(new_weights);
}

void leave_out(std::vector<std::uint8_t>& counts, Random& random) {
  const double kept = random.uniform(0.4, 1);
  const std::array<double, 2> of_polarity{kept * random.uniform(0.7, 1), kept * random.uniform(0.7, 1)};
  constexpr std::size_t half = pixels / 2;
  for (std::size_t first = 0; first < counts.size(); first += half) {
    for (std::size_t i = first; i < first + half; ++i) {
      if (counts[i] > 0) counts[i] = thinned(counts[i], of_polarity[first / half % 2], random);
    }
  }
}

void add_noise(std::vector<std::uint8_t>& counts, Random& random) {
  const double mean = std::exp(random.uniform(std::log(0.002), std::log(0.06)));
  for (std::uint64_t i = random.poisson(mean * static_cast<double>(counts.size())); i > 0; --i) {
    std::uint8_t& count = counts[random.below(counts.size())];
    if (count < 255) ++count;
  }
}

const TickSpan* one_of(const StreamRun& run, Touch touch, Random& random) {
  const auto is_wanted = [touch](const TickSpan& span) { return span.touch == touch; };
  const auto count = static_cast<std::size_t>(std::count_if(run.touches.begin(), run.touches.end(), is_wanted));
  if (count == 0) return nullptr;
  std::size_t skipped = random.below(count);
  return &*std::find_if(run.touches.begin(), run.touches.end(),
                        [&](const TickSpan& span) { return is_wanted(span) && skipped-- == 0; });
}

}  // namespace

StreamCrops::StreamCrops(std::span<const StreamRun> runs, std::uint64_t seed) : runs_(runs), seed_(seed) {
  if (runs.empty() || std::any_of(runs.begin(), runs.end(), [](const StreamRun& run) { return run.ticks == 0; }))
    throw Error("training of kind stream: a run without ticks; expected runs of a tick at least");
}

StreamCrops::Crop StreamCrops::cut(const StreamRun& run, Random& random) const {
  constexpr std::size_t margin = 20, cold = 15;
  const std::size_t last = run.ticks > ticks ? run.ticks - ticks : 0;
  std::size_t begin = random.below(last + 1);
  if (!run.touches.empty() && happens(random, 0.6)) {
    const std::size_t onset = run.touches[random.below(run.touches.size())].begin, ahead = within(random, margin, ticks - margin);
    begin = std::min(last, onset > ahead ? onset - ahead : 0);
  }
  const std::size_t end = std::min(run.ticks, begin + ticks);
  Crop crop{counts_of(run, begin, end),
            {run.truth.begin() + static_cast<std::ptrdiff_t>(begin), run.truth.begin() + static_cast<std::ptrdiff_t>(end)},
            {run.weights.begin() + static_cast<std::ptrdiff_t>(begin), run.weights.begin() + static_cast<std::ptrdiff_t>(end)}};
  crop.counts.resize(ticks * pixels);
  crop.truth.resize(ticks, Touch::none);
  crop.weights.resize(ticks, 0.0F);
  // A piece from the middle of a run begins without a memory of what came before.
  if (begin > 0) std::fill_n(crop.weights.begin(), cold, 0.0F);
  return crop;
}

void StreamCrops::put_other_motion(const StreamRun& run, Crop& crop, Random& random) const {
  const auto is_quiet = [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      if (k >= ticks || crop.truth[k] != Touch::none || crop.weights[k] == 0) return false;
    }
    return true;
  };
  const auto put = [&](const std::vector<std::uint8_t>& motion, std::size_t begin, std::size_t after) {
    const std::size_t count = std::min(motion.size() / pixels, ticks - begin);
    std::copy_n(motion.begin(), count * pixels, crop.counts.begin() + static_cast<std::ptrdiff_t>(begin * pixels));
    for (std::size_t k = begin; k < std::min(ticks, begin + count + after); ++k) crop.weights[k] *= 2;
  };
  const std::size_t begin = within(random, 20, ticks - 121);
  const std::size_t kind = random.below(4);
  if (kind == 0) {  // micro-slip
    const TickSpan* touch = one_of(run, Touch::slip, random);
    if (touch == nullptr) touch = one_of(run, Touch::press, random);
    if (touch == nullptr) return;
    const std::size_t first = touch->begin + random.below(60), count = within(random, 4, 25);
    if (first + count > run.ticks || !is_quiet(begin, begin + count)) return;
    const std::vector<std::uint8_t> whole = counts_of(run, first, first + count);
    std::vector<std::uint8_t> motion(crop.counts.begin() + static_cast<std::ptrdiff_t>(begin * pixels),
                                     crop.counts.begin() + static_cast<std::ptrdiff_t>((begin + count) * pixels));
    const auto order = by_events(whole);
    constexpr std::size_t liveliest = patches / 3;
    for (std::size_t i = within(random, 1, 4); i > 0; --i) copy_patch(whole, motion, order[random.below(liveliest)]);
    put(motion, begin, 5);
    return;
  }
  if (kind < 3) {  // release; and re-contact
    const TickSpan* press = one_of(run, Touch::press, random);
    if (press == nullptr) return;
    const std::size_t first = press->begin > 2 ? press->begin - 2 : 0;
    const std::size_t count = std::min(press->end - first, within(random, 20, 79));
    if (!is_quiet(begin, std::min(ticks, begin + count))) return;
    const std::vector<std::uint8_t> forwards = counts_of(run, first, first + count);
    std::vector<std::uint8_t> backwards = forwards;
    reverse_ticks(backwards);
    move_pixels(backwards, exchanged_polarities());
    put(backwards, begin, 0);
    const std::size_t again = begin + count + random.below(20);
    if (kind == 2 && again + 5 < ticks && is_quiet(again, std::min(ticks, again + count))) put(forwards, again, 0);
    return;
  }
  const TickSpan* slip = one_of(run, Touch::slip, random);  // firm lift
  if (slip == nullptr) return;
  const std::size_t whole = within(random, 2, 8), dying = within(random, 2, 9), first = slip->begin > 0 ? slip->begin - 1 : 0;
  const std::size_t end = std::min(run.ticks, first + whole + dying);
  if (!is_quiet(begin, begin + (end - first))) return;
  std::vector<std::uint8_t> motion = counts_of(run, first, end);
  for (std::size_t k = whole; k < end - first; ++k) {
    const double kept = 1 - static_cast<double>(k - whole + 1) / static_cast<double>(dying + 1);
    for (std::size_t i = 0; i < pixels; ++i) motion[k * pixels + i] = thinned(motion[k * pixels + i], kept, random);
  }
  put(motion, begin, 10);
}

std::vector<std::uint8_t> StreamCrops::quiet(std::size_t count, Random& random) const {
  for (std::size_t attempt = 0; attempt < 50; ++attempt) {
    const StreamRun& run = runs_[random.below(runs_.size())];
    if (run.ticks <= count) continue;
    const std::size_t begin = random.below(run.ticks - count);
    bool is_quiet = true;
    for (std::size_t k = begin; k < begin + count; ++k) is_quiet = is_quiet && run.truth[k] == Touch::none && run.weights[k] == 1;
    if (is_quiet) return counts_of(run, begin, begin + count);
  }
  return {};
}

/// Up to 6 patches see what they saw in a quiet piece of some run, again and again.
void StreamCrops::place_quiet(Crop& crop, Random& random) const {
  constexpr std::size_t repeated = 60;
  const std::vector<std::uint8_t> piece = quiet(repeated, random);
  if (piece.empty()) return;
  for (std::size_t i = within(random, 1, 6); i > 0; --i) copy_patch(piece, crop.counts, random.below(patches));
}

void StreamCrops::change(Crop& crop, Random& random) const {
  Moved moved{.mirrored_in_x = happens(random, 0.5), .mirrored_in_y = happens(random, 0.5), .rows = 0, .columns = 0};
  if (happens(random, 0.5)) {
    // Up to 2/3 of a place in each direction, around.
    constexpr std::size_t most_rows = Layout::rows * 2 / 3, most_columns = Image::fine * Layout::columns * 2 / 3;
    moved.rows = (Image::rows + random.below(2 * most_rows + 1) - most_rows) % Image::rows;
    moved.columns = (Image::columns + random.below(2 * most_columns + 1) - most_columns) % Image::columns;
  }
  move_pixels(crop.counts, sources_of(moved));
  if (happens(random, 0.3)) place_quiet(crop, random);
  if (happens(random, 0.4)) change_speed(crop.counts, crop.truth, crop.weights, random.uniform(0.6, 1.6), random);
  if (happens(random, 0.5)) leave_out(crop.counts, random);
  if (happens(random, 0.4)) add_noise(crop.counts, random);
}

StreamBatch StreamCrops::batch(std::uint64_t step, unsigned threads) const {
  constexpr std::size_t inputs_of_crop = ticks * Layout::places * (Layout::cells_of_place + 1);
  StreamBatch batch{std::vector<float>(crops * inputs_of_crop), std::vector<std::int64_t>(crops * ticks),
                    std::vector<float>(crops * ticks)};
  parallel_for(crops, threads, [&](std::size_t i) {
    Random random(seed_for(seed_, {"crop", std::to_string(step), std::to_string(i)}));
    const StreamRun& run = runs_[random.below(runs_.size())];
    Crop crop = cut(run, random);
    if (happens(random, 0.3)) put_other_motion(run, crop, random);
    change(crop, random);
    stream_inputs(crop.counts, std::span(batch.inputs).subspan(i * inputs_of_crop, inputs_of_crop));
    for (std::size_t k = 0; k < ticks; ++k) {
      batch.truth[i * ticks + k] = static_cast<std::int64_t>(crop.truth[k]);
      batch.weights[i * ticks + k] = crop.weights[k];
    }
  });
  return batch;
}

void stream_inputs(std::span<const std::uint8_t> counts, std::span<float> inputs) {
  static const std::array<float, 256> log1p_of = [] {
    std::array<float, 256> of{};
    for (std::size_t n = 0; n < of.size(); ++n) of[n] = std::log1p(static_cast<float>(n));
    return of;
  }();
  static const std::array<std::uint16_t, pixels> cell_of = [] {
    std::array<std::uint16_t, pixels> of{};
    for (std::size_t polarity = 0; polarity < 2; ++polarity) {
      for (std::size_t row = 0; row < Image::rows; ++row) {
        for (std::size_t column = 0; column < Image::columns; ++column)
          of[Image::at(polarity, row, column)] = static_cast<std::uint16_t>(Layout::cell(polarity, row, column / Image::fine));
      }
    }
    return of;
  }();
  std::size_t next = 0;
  for (std::size_t first = 0; first < counts.size(); first += pixels) {
    std::array<std::uint32_t, Layout::cells> sums{};
    for (std::size_t i = 0; i < pixels; ++i) sums[cell_of[i]] += counts[first + i];
    for (std::size_t place = 0; place < Layout::places; ++place) {
      std::uint32_t sum = 0;
      for (std::size_t cell = place * Layout::cells_of_place; cell < (place + 1) * Layout::cells_of_place; ++cell) {
        sum += sums[cell];
        inputs[next++] = sums[cell] < log1p_of.size() ? log1p_of[sums[cell]] : std::log1p(static_cast<float>(sums[cell]));
      }
      inputs[next++] = std::log1p(static_cast<float>(sum));
    }
  }
}

}  // namespace tactile::model
