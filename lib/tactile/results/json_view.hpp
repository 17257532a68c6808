#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tactile/core/time.hpp"

namespace tactile::results {

/// How a missing member is read: as null, since files of older versions lack members, or as an error.
enum class MissingMember : std::uint8_t { is_null, is_error };

/// A value in a file of results, or its absence. One of another type than asked for is an `Error` that names file and member.
/// A view into the JSON, which must outlive it.
class JsonView {
 public:
  /// @param where  the file, named in errors
  JsonView(const nlohmann::json& json, std::string where, MissingMember missing = MissingMember::is_null)
      : json_(json.is_null() ? nullptr : &json), where_(std::move(where)), missing_(missing) {}

  explicit operator bool() const { return json_ != nullptr; }
  bool is_number() const { return json_ != nullptr && json_->is_number(); }
  bool is_object() const { return json_ != nullptr && json_->is_object(); }
  JsonView operator[](std::string_view key) const;  ///< @throws Error if this is no object
  /// The member of this name, or of the name that earlier versions gave it. @throws Error  if this is no object
  JsonView renamed(std::string_view key, std::string_view earlier_key) const;
  std::vector<JsonView> items() const;                            ///< of a list; none where there is none
  std::vector<std::pair<std::string, JsonView>> members() const;  ///< of an object, by name; none where there is none

  double number() const;                          ///< NaN where there is none
  std::optional<double> number_if_there() const;  ///< nothing where there is none
  std::int64_t whole_number() const;              ///< 0 where there is none
  std::uint64_t count() const;                    ///< 0 where there is none
  std::optional<std::uint64_t> count_if_there() const;
  microseconds milliseconds() const;  ///< of a number of milliseconds; 0 where there is none
  bool truth() const;                 ///< false where there is none
  std::string text() const;           ///< empty where there is none
  std::vector<std::string> texts() const;
  std::vector<std::uint64_t> counts() const;

  nlohmann::json copy() const;  ///< null where there is none

  /// Whatever it is, in words: texts as they are, lists with commas, objects as JSON.
  std::string words() const;

  /// A result, by its `from_json(const JsonView&, T&)`; an empty one where there is none.
  template <class T>
  T get() const {
    T result{};
    from_json(*this, result);
    return result;
  }

  /// The same; nothing where there is none.
  template <class T>
  std::optional<T> if_there() const {
    return json_ == nullptr ? std::nullopt : std::optional<T>(get<T>());
  }

  template <class T>
  std::vector<T> list_of() const {
    std::vector<T> results;
    for (const JsonView& item : items()) results.push_back(item.get<T>());
    return results;
  }

  const std::string& where() const { return where_; }  ///< "FILE: 'MEMBER'"

 private:
  JsonView(const nlohmann::json* json, std::string where, MissingMember missing)
      : json_(json), where_(std::move(where)), missing_(missing) {}
  [[noreturn]] void refuse(std::string_view expected) const;

  const nlohmann::json* json_;
  std::string where_;
  MissingMember missing_;
};

/// A text in JSON, null where it is empty.
nlohmann::json text_or_null(const std::string& text);

}  // namespace tactile::results
