#include "tactile/labels/unlikely_presses.hpp"

#include <algorithm>

#include "tactile/core/duration_units.hpp"

namespace tactile::labels {

std::vector<LabelFlag> unlikely_presses(const Labels& labels) {
  std::vector<LabelFlag> flags;
  for (std::size_t i = 0; i < labels.intervals.size(); ++i) {
    const LabelledInterval& press = labels.intervals[i];
    if (press.touch != Touch::press) continue;
    if (const microseconds lasts = between(press.start.at, press.end.at); lasts < shortest_press) {
      flags.push_back(flag_of(
          doubt("press-short", "the press lasts {:.0f} ms; expected {:.0f} ms or more", in_ms(lasts), in_ms(shortest_press)), i));
    }
    if (i == 0 || labels.intervals[i - 1].touch != Touch::press) continue;
    const LabelledInterval& earlier = labels.intervals[i - 1];
    const bool was_released = std::any_of(labels.releases.begin(), labels.releases.end(), [&](const TouchInterval& release) {
      return release.start >= earlier.start.at && release.start <= press.start.at;
    });
    if (!was_released)
      flags.push_back(
          flag_of(doubt("press-after-press",
                        "it follows a press without a release between them: the object may have turned or slipped in part, or "
                        "this is the rest of that press (then reject it)"),
                  i));
  }
  return flags;
}

}  // namespace tactile::labels
