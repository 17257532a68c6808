#include "tactile/trade/trade_point.hpp"

namespace tactile {

TestedRuns TestedRuns::from(std::size_t first) const {
  const auto begin = static_cast<std::ptrdiff_t>(first);
  return {.indexes = {indexes.begin() + begin, indexes.end()},
          .judged = {judged.begin() + begin, judged.end()},
          .recordings = {recordings.begin() + begin, recordings.end()}};
}

TimedWay way_of(const TradePoint& point) {
  const TradeSetting& setting = point.setting;
  return {setting.rendering, setting.engine, setting.precision, setting.sparse, point.networks.front().bundle.folder};
}

std::optional<std::uint64_t> gate_of(const TradeSetting& setting, const TradeNetwork& network) {
  if (!setting.gate) return std::nullopt;
  return gate_limit(network.bundle, read_description(network.bundle));
}

}  // namespace tactile
