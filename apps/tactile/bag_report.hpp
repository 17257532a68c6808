#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tactile/bags/bag_contents.hpp"

namespace tactile::cli {

/// What `info` shows of a bag.
nlohmann::json json_of_bag(const std::string& name, const bags::BagContents& contents);
std::string text_of_bag(const std::string& name, const bags::BagContents& contents);

/// What is damaged or lost, a sentence each; empty if nothing is.
std::vector<std::string> reasons_of(const bags::BagContents& contents);

}  // namespace tactile::cli
