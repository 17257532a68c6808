#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tactile/core/error.hpp"

namespace tactile::review {

/// What a page asks of its server, after the server's checks.
struct PageRequest {
  std::string method;                        ///< "GET" or "POST"
  std::string path;                          ///< decoded: "/api/runs/fan/01"
  std::map<std::string, std::string> query;  ///< decoded; of a name that is given twice the first
  std::string body;
};

/// Gives the parts of an answer as they come about, on the connection's thread: the next part; an empty text if there is none
/// within 100 ms; nothing at the end. It is only asked while the client takes what it is sent.
using PageParts = std::function<std::optional<std::string>()>;

struct PageResponse {
  int status = 200;
  std::string type = "application/json";
  std::string body;
  std::vector<std::pair<std::string, std::string>> headers{};
  PageParts parts{};  ///< if there are any: sent instead of `body`
};

/// A request that is not answered with what it asked for: its status, and a sentence for the person.
class Refusal : public Error {
 public:
  Refusal(int status, const std::string& sentence) : Error(sentence), status_(status) {}
  int status() const { return status_; }

 private:
  int status_;
};

PageResponse json_response(const nlohmann::json& json, int status = 200);
PageResponse refusal_response(int status, std::string_view sentence);  ///< {"error": sentence}

/// The parameter as a whole number from `low` to `high`; `otherwise` where it is missing.
/// @throws Refusal  (400) if it is none, or it is missing and there is no `otherwise`
std::int64_t whole_number_of(const PageRequest& request, const std::string& name, std::int64_t low, std::int64_t high,
                             std::optional<std::int64_t> otherwise = std::nullopt);

/// The parameter; empty where it is missing.
std::string text_of(const PageRequest& request, const std::string& name);

/// The body as a JSON object. @throws Refusal  (400) if it is none
nlohmann::json json_in(const PageRequest& request);

/// The parts of a path between its slashes: "/api/runs" has "api" and "runs".
std::vector<std::string> parts_of(std::string_view path);

}  // namespace tactile::review
