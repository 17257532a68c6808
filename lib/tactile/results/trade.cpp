#include "tactile/results/trade.hpp"

namespace tactile::results {

std::string Trade::cpu() const { return JsonView(machine, "machine")["cpu"].text(); }

}  // namespace tactile::results
