#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tactile/core/host_clock.hpp"

namespace tactile::cli {

/// What a person may choose while runs are recorded, at the terminal or on the page.
enum class RecordChoice : std::uint8_t {
  start,  ///< the next run
  stop,   ///< end the run that is recorded
  redo,   ///< repeat the last run
  skip,   ///< the rest of the object's runs
  end     ///< the session
};

constexpr std::string_view name_of(RecordChoice choice) {
  constexpr std::string_view names[] = {"start", "stop", "redo", "skip", "end"};
  return names[static_cast<std::size_t>(choice)];
}

struct OfferedChoice {
  RecordChoice choice;
  std::string words;  ///< "Redo fan/02"
};

/// What is asked at a moment. Each question has another number, so that an answer that comes late answers no other.
struct RecordQuestion {
  std::uint64_t number = 0;
  std::vector<OfferedChoice> offered{};
};

/// The choices of the page: its threads give them, and the thread that records takes them.
class PageChoices {
 public:
  /// Begins the next question; what was chosen before is dropped.
  void ask(std::vector<OfferedChoice> offered) {
    const std::scoped_lock lock(guard_);
    question_ = {.number = question_.number + 1, .offered = std::move(offered)};
    chosen_.reset();
  }
  RecordQuestion question() const {
    const std::scoped_lock lock(guard_);
    return question_;
  }

  /// Whether this question is still asked, has no answer yet and offers the choice.
  bool choose(std::uint64_t number, const std::string& name) {
    const std::scoped_lock lock(guard_);
    if (number != question_.number || chosen_) return false;
    for (const OfferedChoice& offered : question_.offered) {
      if (name_of(offered.choice) == name) chosen_ = offered.choice;
    }
    was_used_ = was_used_ || chosen_.has_value();
    return chosen_.has_value();
  }

  /// What was chosen; nothing if the question has no answer yet.
  std::optional<RecordChoice> chosen() const {
    const std::scoped_lock lock(guard_);
    return chosen_;
  }
  /// Whether a person has ever chosen on the page.
  bool was_used() const {
    const std::scoped_lock lock(guard_);
    return was_used_;
  }

 private:
  mutable std::mutex guard_;
  // A page that outlives the program must not take a question of the next program for one that it knows.
  RecordQuestion question_{.number = static_cast<std::uint64_t>(us_of(host_now()))};
  std::optional<RecordChoice> chosen_;
  bool was_used_ = false;
};

}  // namespace tactile::cli
