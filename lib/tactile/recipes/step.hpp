#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/recipes/recipe.hpp"

namespace tactile::recipes {

/// One recipe at work. Events come and leave ascending in time.
class Step {
 public:
  Step() = default;
  virtual ~Step() = default;
  Step(const Step&) = delete;
  Step& operator=(const Step&) = delete;

  virtual void push(std::span<const events::Event> events, std::vector<events::Event>& out) = 0;
  virtual void finish(std::vector<events::Event>& out) = 0;  ///< appends what it still holds
};

/// What a step is made from. The recipe is checked, and its severity is not 0.
struct StepInput {
  const Recipe& recipe;
  events::SensorSize size;
  std::uint64_t seed = 0;  ///< of this step, for all of its random numbers

  double parameter(std::string_view name) const { return parameter_of(recipe, name); }
};

/// A step that turns each event by itself into events of the same or of ascending times: change(event, out).
template <class Change>
class EventStep final : public Step {
 public:
  explicit EventStep(Change change) : change_(std::move(change)) {}

  void push(std::span<const events::Event> events, std::vector<events::Event>& out) override {
    for (const events::Event& event : events) change_(event, out);
  }
  void finish(std::vector<events::Event>&) override {}

 private:
  Change change_;
};

template <class Change>
std::unique_ptr<Step> event_step(Change change) {
  return std::make_unique<EventStep<Change>>(std::move(change));
}

/// A recipe of the list and how it is made.
struct RecipeEntry {
  RecipeInfo info;
  std::unique_ptr<Step> (*make)(const StepInput&);
};
std::span<const RecipeEntry> recipe_entries();

// noise.cpp
std::unique_ptr<Step> make_noise(const StepInput& input);
std::unique_ptr<Step> make_hot_pixels(const StepInput& input);
// flicker.cpp
std::unique_ptr<Step> make_flicker_100(const StepInput& input);
std::unique_ptr<Step> make_flicker_120(const StepInput& input);
// lost_events.cpp
std::unique_ptr<Step> make_dead_rows(const StepInput& input);
std::unique_ptr<Step> make_dead_columns(const StepInput& input);
std::unique_ptr<Step> make_loss(const StepInput& input);
std::unique_ptr<Step> make_burst_loss(const StepInput& input);
std::unique_ptr<Step> make_packet_loss(const StepInput& input);
std::unique_ptr<Step> make_readout_limit(const StepInput& input);
// changed_times.cpp
std::unique_ptr<Step> make_jitter(const StepInput& input);
std::unique_ptr<Step> make_rounding(const StepInput& input);
std::unique_ptr<Step> make_late(const StepInput& input);
// moved_picture.cpp
std::unique_ptr<Step> make_shift(const StepInput& input);
std::unique_ptr<Step> make_rotate(const StepInput& input);
std::unique_ptr<Step> make_scale(const StepInput& input);
std::unique_ptr<Step> make_mirror_x(const StepInput& input);
std::unique_ptr<Step> make_mirror_y(const StepInput& input);
std::unique_ptr<Step> make_vibration(const StepInput& input);
// changed_pixels.cpp
std::unique_ptr<Step> make_polarity(const StepInput& input);
std::unique_ptr<Step> make_threshold(const StepInput& input);

}  // namespace tactile::recipes
