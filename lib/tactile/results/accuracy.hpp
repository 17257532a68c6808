#pragma once

#include <map>
#include <string>

#include "tactile/results/figure.hpp"
#include "tactile/results/members.hpp"

namespace tactile::results {

/// The share of balanced samples predicted correctly: of each object over all samples of its runs, and the mean over objects.
struct Accuracy {
  Figure mean{};
  std::map<std::string, Figure> objects{};
};

template <class Members>
void list_members(Members& members, Accuracy& accuracy) {
  members("mean", accuracy.mean);
  members("objects", accuracy.objects);
}

}  // namespace tactile::results
