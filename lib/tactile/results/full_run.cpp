#include "tactile/results/full_run.hpp"

#include <fmt/format.h>

#include <bit>
#include <charconv>
#include <iterator>

#include "tactile/core/error.hpp"

namespace tactile::results {
namespace {

constexpr std::size_t digits_of_one = 8;  // of a float32

using Probabilities = std::vector<std::array<float, touch_count>>;

std::string hexadecimal(const Probabilities& probabilities) {
  std::string text;
  text.reserve(probabilities.size() * touch_count * digits_of_one);
  for (const auto& of_tick : probabilities) {
    for (const float value : of_tick) fmt::format_to(std::back_inserter(text), "{:08x}", std::bit_cast<std::uint32_t>(value));
  }
  return text;
}

/// @throws Error  unless they are so many, in [0, 1]
Probabilities probabilities_in(const JsonView& view, std::size_t ticks) {
  const std::string text = view.text();
  Probabilities probabilities(ticks);
  bool is_sound = text.size() == ticks * touch_count * digits_of_one;
  for (std::size_t i = 0; is_sound && i < ticks * touch_count; ++i) {
    std::uint32_t bits = 0;
    const char* const begin = text.data() + i * digits_of_one;
    const auto read = std::from_chars(begin, begin + digits_of_one, bits, 16);
    const auto value = std::bit_cast<float>(bits);
    is_sound = read.ec == std::errc() && read.ptr == begin + digits_of_one && value >= 0 && value <= 1;
    probabilities[i / touch_count][i % touch_count] = value;
  }
  if (!is_sound) throw Error(view.where() + " are not three float32 from 0 to 1 per tick; expected 24 hexadecimal digits each");
  return probabilities;
}

}  // namespace

void to_json(nlohmann::json& json, const FullRun& run) {
  std::string digits;
  for (const Touch touch : run.verdicts) digits += static_cast<char>('0' + static_cast<int>(touch));
  json = {{"run", run.run},
          {"first_us", us_of(run.ticks.first)},
          {"tick_us", run.ticks.tick.count()},
          {"said", digits},
          {"probabilities", hexadecimal(run.probabilities)},
          {"events", run.events}};
}

void from_json(const JsonView& json, FullRun& run) {
  run.run = json["run"].text();
  run.ticks.first = camera_time(json["first_us"].whole_number());
  run.ticks.tick = microseconds{json["tick_us"].whole_number()};
  run.events = json["events"].counts();
  const JsonView digits = json["said"];
  for (const char digit : digits.text()) {
    if (digit < '0' || digit > '2') throw Error(digits.where() + " has a digit other than 0, 1 and 2");
    run.verdicts.push_back(static_cast<Touch>(digit - '0'));
  }
  run.ticks.count = static_cast<std::int64_t>(run.verdicts.size());
  if (const JsonView probabilities = json["probabilities"]; !probabilities.text().empty())
    run.probabilities = probabilities_in(probabilities, run.verdicts.size());
  if (run.events.size() != run.verdicts.size() || run.ticks.tick <= microseconds{0})
    throw Error(json.where() + ": the numbers of verdicts and event counts differ; expected a full run of a model");
}

}  // namespace tactile::results
