#include "tactile/recipes/recipe_stream.hpp"

#include <fmt/core.h>

#include <map>
#include <string>

#include "tactile/core/error.hpp"
#include "tactile/core/random.hpp"
#include "tactile/recipes/step.hpp"

namespace tactile::recipes {
namespace {

std::unique_ptr<Step> made_step(const StepInput& input) {
  for (const RecipeEntry& entry : recipe_entries()) {
    if (entry.info.name == input.recipe.name) return entry.make(input);
  }
  throw Error("recipe " + input.recipe.name + ": is unknown; expected one of the list");  // `check` has refused it
}

}  // namespace

struct RecipeStream::State {
  events::SensorSize size;
  std::vector<std::unique_ptr<Step>> steps;
  std::vector<events::Event> before, after;  ///< of a step
  CameraTime last = CameraTime::min();

  void check_events(std::span<const events::Event> events) {
    for (const events::Event& event : events) {
      if (event.t < last) {
        throw Error(fmt::format("events to worsen go back in time, from {} to {} us; expected ascending times", us_of(last),
                                us_of(event.t)));
      }
      last = event.t;
      if (event.x < 0 || event.y < 0 || event.x >= size.width || event.y >= size.height) {
        throw Error(fmt::format("events to worsen: one at x {}, y {}; expected all inside the {} x {} pixels", event.x, event.y,
                                size.width, size.height));
      }
    }
  }

  /// Leads `before` through the steps from number `first` on.
  void pass(std::size_t first) {
    for (std::size_t i = first; i < steps.size(); ++i) {
      after.clear();
      steps[i]->push(before, after);
      std::swap(before, after);
    }
  }
};

RecipeStream::RecipeStream(std::span<const Recipe> recipes, events::SensorSize size) : state_(std::make_unique<State>()) {
  if (size.width < 1 || size.height < 1 || size.width > events::most_side || size.height > events::most_side) {
    throw Error(
        fmt::format("recipes: a sensor of {} x {} pixels; expected 1 to {} each", size.width, size.height, events::most_side));
  }
  state_->size = size;
  std::map<std::string, int> seen;  // the same recipe twice draws other numbers
  for (const Recipe& recipe : recipes) {
    check(recipe);
    const int number = ++seen[recipe.name];
    if (recipe.severity == harmless) continue;
    const std::uint64_t seed = seed_for(recipe.seed, {"recipe", recipe.name, std::to_string(number)});
    state_->steps.push_back(made_step({recipe, size, seed}));
  }
}

RecipeStream::~RecipeStream() = default;
RecipeStream::RecipeStream(RecipeStream&&) noexcept = default;
RecipeStream& RecipeStream::operator=(RecipeStream&&) noexcept = default;

void RecipeStream::push(std::span<const events::Event> events, std::vector<events::Event>& out) {
  state_->check_events(events);
  state_->before.assign(events.begin(), events.end());
  state_->pass(0);
  out.insert(out.end(), state_->before.begin(), state_->before.end());
}

void RecipeStream::finish(std::vector<events::Event>& out) {
  for (std::size_t i = 0; i < state_->steps.size(); ++i) {
    state_->before.clear();
    state_->steps[i]->finish(state_->before);
    state_->pass(i + 1);
    out.insert(out.end(), state_->before.begin(), state_->before.end());
  }
}

std::vector<events::Event> worsened(std::span<const events::Event> events, std::span<const Recipe> recipes,
                                    events::SensorSize size) {
  constexpr std::size_t piece = 1 << 16;  // the memory of the steps stays small
  RecipeStream stream(recipes, size);
  std::vector<events::Event> out;
  for (std::size_t begin = 0; begin < events.size(); begin += piece)
    stream.push(events.subspan(begin, std::min(piece, events.size() - begin)), out);
  stream.finish(out);
  return out;
}

}  // namespace tactile::recipes
