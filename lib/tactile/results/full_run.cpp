#include "tactile/results/full_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <iterator>
#include <optional>

#include "tactile/core/error.hpp"

namespace tactile::results {
namespace {

constexpr std::size_t digits_of_one = 8;  // of a float32

/// Nothing unless the text has `count` values.
std::optional<std::vector<float>> floats_in(const std::string& text, std::size_t count) {
  if (text.size() != count * digits_of_one) return std::nullopt;
  std::vector<float> values;
  for (std::size_t i = 0; i < count; ++i) {
    std::uint32_t bits = 0;
    const char* const begin = text.data() + i * digits_of_one;
    const auto read = std::from_chars(begin, begin + digits_of_one, bits, 16);
    if (read.ec != std::errc() || read.ptr != begin + digits_of_one) return std::nullopt;
    values.push_back(std::bit_cast<float>(bits));
  }
  return values;
}

using Probabilities = std::vector<std::array<float, touch_count>>;

std::string hexadecimal(const Probabilities& probabilities) {
  std::string text;
  for (const auto& of_tick : probabilities) {
    for (const float value : of_tick) fmt::format_to(std::back_inserter(text), "{:08x}", std::bit_cast<std::uint32_t>(value));
  }
  return text;
}

/// @throws Error  unless there are three for each tick, in [0, 1]
Probabilities probabilities_in(const JsonView& view, std::size_t ticks) {
  const auto values = floats_in(view.text(), ticks * touch_count);
  const auto is_probability = [](float value) { return value >= 0 && value <= 1; };
  if (!values || !std::all_of(values->begin(), values->end(), is_probability))
    throw Error(view.where() + " are not three float32 from 0 to 1 per tick; expected 24 hexadecimal digits each");
  Probabilities probabilities(ticks);
  for (std::size_t i = 0; i < values->size(); ++i) probabilities[i / touch_count][i % touch_count] = (*values)[i];
  return probabilities;
}

}  // namespace

void to_json(nlohmann::json& json, const FullRun& run) {
  std::string digits;
  for (const Touch touch : run.verdicts) digits += static_cast<char>('0' + static_cast<int>(touch));
  json = {{"run", run.run},
          {"first_us", us_of(run.ticks.first)},
          {"tick_us", run.ticks.tick.count()},
          {"predicted", digits},
          {"probabilities", hexadecimal(run.probabilities)},
          {"events", run.events}};
}

void from_json(const JsonView& json, FullRun& run) {
  run.run = json["run"].text();
  run.ticks.first = camera_time(json["first_us"].whole_number());
  run.ticks.tick = microseconds{json["tick_us"].whole_number()};
  run.events = json["events"].counts();
  const JsonView digits = json.renamed("predicted", "said");
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
