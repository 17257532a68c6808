#include "tactile/capture/run_drops.hpp"

namespace tactile::capture {
namespace {

nlohmann::json json_of(const LostElements& lost) {
  return {{"packets", lost.packets}, {"events", lost.events}, {"others", lost.others}};
}

}  // namespace

LostElements RunDrops::total() const {
  LostElements sum;
  for (const LostElements& part : {queue_full, back_in_time, outside, unwritten, source}) sum += part;
  return sum;
}

nlohmann::json json_of(const RunDrops& drops) {
  const LostElements total = drops.total();
  return {{"packets", total.packets},
          {"events", total.events},
          {"others", total.others},
          {"by_reason",
           {{"queue_full", json_of(drops.queue_full)},
            {"back_in_time", json_of(drops.back_in_time)},
            {"outside", json_of(drops.outside)},
            {"unwritten", json_of(drops.unwritten)},
            {"source", json_of(drops.source)}}}};
}

}  // namespace tactile::capture
