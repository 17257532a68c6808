#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

// What a JSON value is made of is compiled once, in json_templates.cpp: it is a third of what a file that uses it takes to
// compile.
extern template class nlohmann::basic_json<>;
extern template class nlohmann::detail::serializer<nlohmann::json>;
extern template class std::vector<nlohmann::json>;
