#include "tactile/model/bundle/transitions.hpp"

#include <algorithm>
#include <cmath>

#include "tactile/core/duration_units.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"

namespace tactile::model {
namespace {

std::size_t place_of(Touch touch) { return static_cast<std::size_t>(touch); }

}  // namespace

double Transitions::rate(Touch from, Touch to) const {
  return (static_cast<double>(counts[place_of(from)][place_of(to)]) + 0.5) / (seconds[place_of(from)] + 1);
}

void Transitions::add(CameraTime begin, CameraTime end, std::span<const TouchInterval> labelled) {
  Touch before = Touch::none;
  CameraTime until = begin;
  const auto change_to = [&](Touch touch) {
    if (touch != before) ++counts[place_of(before)][place_of(touch)];
    before = touch;
  };
  for (const TouchInterval& interval : labelled) {
    if (interval.start > until) {
      change_to(Touch::none);
      seconds[place_of(Touch::none)] += in_s(interval.start - until);
    }
    change_to(interval.touch);
    seconds[place_of(interval.touch)] += in_s(interval.end - std::max(interval.start, until));
    until = interval.end;
  }
  if (end <= until) return;
  change_to(Touch::none);
  seconds[place_of(Touch::none)] += in_s(end - until);
}

void to_json(nlohmann::json& json, const Transitions& transitions) {
  json = {{"counts", transitions.counts}, {"seconds", transitions.seconds}};
}

void from_json(const nlohmann::json& json, Transitions& transitions) {
  const std::string where = "transitions";
  const auto counts = member<std::vector<std::vector<std::uint64_t>>>(json, "counts", where);
  const auto seconds = member<std::vector<double>>(json, "seconds", where);
  const auto fits = [](const auto& values) { return values.size() == touch_count; };
  const auto is_time = [](double s) { return std::isfinite(s) && s >= 0; };
  if (!fits(counts) || !std::all_of(counts.begin(), counts.end(), fits) || !fits(seconds) ||
      !std::all_of(seconds.begin(), seconds.end(), is_time)) {
    throw Error(where + ": expected 3 x 3 counts and 3 times of 0 s or more, in the order none, press, slip");
  }
  for (std::size_t i = 0; i < touch_count; ++i) {
    std::copy(counts[i].begin(), counts[i].end(), transitions.counts[i].begin());
    transitions.seconds[i] = seconds[i];
  }
}

}  // namespace tactile::model
