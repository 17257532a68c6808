#include "tactile/model/training/stressed_heatmaps.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "tactile/core/parallel.hpp"
#include "tactile/core/random.hpp"
#include "tactile/heatmaps/render_samples.hpp"
#include "tactile/recipes/recipe_stream.hpp"

namespace tactile::model {

std::optional<recipes::Recipe> drawn_stress(std::span<const recipes::Recipe> recipes, std::uint64_t seed, unsigned epoch,
                                            std::string_view run) {
  Random random(seed_for(seed, {"stress", std::to_string(epoch), run}));
  if (recipes.empty() || random.below(2) == 0) return std::nullopt;
  recipes::Recipe recipe = recipes[random.below(recipes.size())];
  recipe.severity *= 1 - random.uniform();
  if (recipes::recipe_named(recipe.name).whole) recipe.severity = std::ceil(recipe.severity);
  recipe.seed = random.bits();
  return recipe;
}

StressedHeatmaps::StressedHeatmaps(const windows::Dataset& dataset, const ModelSettings& settings,
                                   std::span<const std::uint32_t> samples, std::span<const std::uint8_t> heatmaps,
                                   unsigned threads)
    : dataset_(dataset), settings_(settings), samples_(samples), clean_(heatmaps), threads_(threads) {
  for (std::size_t place = 0; place < samples.size(); ++place) {
    const std::uint32_t run = dataset.samples()[samples[place]].run_index;
    auto found = std::find_if(runs_.begin(), runs_.end(), [&](const Run& known) { return known.index == run; });
    if (found == runs_.end()) found = runs_.insert(found, Run{run, {}});
    found->places.push_back(place);
  }
}

std::span<const std::uint8_t> StressedHeatmaps::of_epoch(unsigned epoch) {
  stressed_.assign(clean_.begin(), clean_.end());
  parallel_for(runs_.size(), threads_, [&](std::size_t i) {
    const auto recipe = drawn_stress(settings_.training.augmentation.stress, settings_.training.seed, epoch,
                                     windows::name_of(dataset_.runs()[runs_[i].index]));
    if (recipe) render(runs_[i], *recipe);
  });
  return stressed_;
}

void StressedHeatmaps::render(const Run& run, const recipes::Recipe& recipe) {
  constexpr std::size_t piece = 1 << 16;  // so that many added events take little memory
  const std::vector<events::Event> events = dataset_.events(run.index);
  std::vector<CameraTime> times;
  for (const std::size_t place : run.places) times.push_back(dataset_.samples()[samples_[place]].t);
  recipes::RecipeStream stream({&recipe, 1}, dataset_.sensor());
  std::size_t given = 0;
  bool is_finished = false;
  const auto next = [&] {
    std::vector<events::Event> out;
    while (out.empty() && given < events.size()) {
      const auto part = std::span(events).subspan(given, std::min(piece, events.size() - given));
      stream.push(part, out);
      given += part.size();
    }
    if (out.empty() && !std::exchange(is_finished, true)) stream.finish(out);
    return out;
  };
  const std::size_t length = stressed_.size() / samples_.size();
  heatmaps::render_events(dataset_.sensor(), next, {&settings_.rendering, 1}, times, [&](std::size_t, std::size_t i) {
    return std::span(stressed_).subspan(run.places[i] * length, length);
  });
}

}  // namespace tactile::model
