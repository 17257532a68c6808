#include "tactile/review/page_message.hpp"

#include <fmt/core.h>

#include "tactile/core/json_text.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/text.hpp"

namespace tactile::review {

PageResponse json_response(const nlohmann::json& json, int status) {
  return {.status = status, .type = "application/json", .body = json_text(json)};
}

PageResponse refusal_response(int status, std::string_view sentence) {
  return json_response({{"error", std::string(sentence)}}, status);
}

std::int64_t whole_number_of(const PageRequest& request, const std::string& name, std::int64_t low, std::int64_t high,
                             std::optional<std::int64_t> otherwise) {
  const auto found = request.query.find(name);
  if (found == request.query.end() && otherwise) return *otherwise;
  const auto number = found == request.query.end() ? std::nullopt : whole_number_in(found->second);
  if (number && *number >= low && *number <= high) return *number;
  const std::string given = found == request.query.end() ? "is missing" : "is " + shown_text(found->second);
  throw Refusal(400, fmt::format("'{}' {}; expected a whole number from {} to {}", name, given, low, high));
}

std::string text_of(const PageRequest& request, const std::string& name) {
  const auto found = request.query.find(name);
  return found == request.query.end() ? std::string() : found->second;
}

nlohmann::json json_in(const PageRequest& request) {
  // A callback bounds the depth: a deeply nested text would exhaust the stack when it is freed.
  constexpr int deepest = 20;
  const auto is_shallow = [](int depth, nlohmann::json::parse_event_t, nlohmann::json&) {
    if (depth > deepest) throw Refusal(400, "the request's body nests values too deeply; expected an edit as JSON");
    return true;
  };
  nlohmann::json json = nlohmann::json::parse(request.body, is_shallow, false);
  if (!json.is_object()) throw Refusal(400, "the request's body is no JSON object; expected an edit as JSON");
  return json;
}

std::vector<std::string> parts_of(std::string_view path) {
  std::vector<std::string> parts;
  while (!path.empty()) {
    const std::size_t end = std::min(path.find('/'), path.size());
    if (end > 0) parts.emplace_back(path.substr(0, end));
    path.remove_prefix(std::min(end + 1, path.size()));
  }
  return parts;
}

}  // namespace tactile::review
