#include "tactile/results/delay_table.hpp"

namespace tactile::results {

void to_json(nlohmann::json& json, const CensoredQuantile& quantile) {
  json = quantile.ms;
  json["is_lower_bound"] = quantile.is_lower_bound;
}

void from_json(const JsonView& json, CensoredQuantile& quantile) {
  if (json) quantile = {json.get<Figure>(), json["is_lower_bound"].truth()};
}

}  // namespace tactile::results
