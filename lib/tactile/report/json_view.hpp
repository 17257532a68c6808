#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tactile/report/result_plots.hpp"

namespace tactile {

/// A value in a file of results, or its absence: null and a member that is not there are the same. One of another type than asked
/// for is an `Error` that names file and member. A view into the JSON, which must outlive it.
class JsonView {
 public:
  /// @param where  the file, told in errors
  JsonView(const nlohmann::json& json, std::string where) : json_(json.is_null() ? nullptr : &json), where_(std::move(where)) {}

  explicit operator bool() const { return json_ != nullptr; }
  bool is_object() const { return json_ != nullptr && json_->is_object(); }
  JsonView operator[](std::string_view key) const;                ///< @throws Error if this is no object
  std::vector<JsonView> items() const;                            ///< of a list; none where there is none
  std::vector<std::pair<std::string, JsonView>> members() const;  ///< of an object, by name; none where there is none

  double number() const;        ///< NaN where there is none
  std::uint64_t count() const;  ///< 0 where there is none
  bool truth() const;           ///< false where there is none
  std::string text() const;     ///< empty where there is none
  std::vector<std::string> texts() const;
  Measured measured() const;  ///< of {value, low, high, n}, or a plain number

  /// Whatever it is, in words: texts as they are, lists with commas, objects as JSON.
  std::string words() const;

 private:
  JsonView(const nlohmann::json* json, std::string where) : json_(json), where_(std::move(where)) {}
  [[noreturn]] void refuse(std::string_view expected) const;

  const nlohmann::json* json_;
  std::string where_;
};

}  // namespace tactile
