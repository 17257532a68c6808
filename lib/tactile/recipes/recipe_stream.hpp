#pragma once

#include <memory>
#include <span>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/recipes/recipe.hpp"

namespace tactile::recipes {

/// Applies recipes to events, piece by piece.
///
/// - The result does not depend on how the events are divided into pieces.
/// - It ascends in time and lies inside the sensor.
/// - Memory follows the piece and what a recipe must hold back: at most the events of its longest delay.
/// - Times near the ends of int64 are held there.
/// - Where no event comes for more than `longest_pause`, there is no recording: time stands still, nothing is added.
class RecipeStream {
 public:
  /// @param recipes  applied in this order; none: events pass unchanged
  /// @throws Error   as `check`, or if a recipe does not fit the sensor
  RecipeStream(std::span<const Recipe> recipes, events::SensorSize size);
  ~RecipeStream();
  RecipeStream(RecipeStream&&) noexcept;
  RecipeStream& operator=(RecipeStream&&) noexcept;

  /// Appends to `out` the worsened events that no later event can change any more.
  /// @param events  ascending in time, also from call to call
  /// @throws Error  if they go back in time or lie outside the sensor; the stream is then of no more use
  void push(std::span<const events::Event> events, std::vector<events::Event>& out);

  /// Appends the rest. `push` must not follow.
  void finish(std::vector<events::Event>& out);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

constexpr microseconds longest_pause{1'000'000};

/// All events at once. @throws Error  as RecipeStream
std::vector<events::Event> worsened(std::span<const events::Event> events, std::span<const Recipe> recipes,
                                    events::SensorSize size);

}  // namespace tactile::recipes
