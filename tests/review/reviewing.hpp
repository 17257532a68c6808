#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "alignment/made_run.hpp"
#include "labels/press_and_slip.hpp"
#include "support/comes_true.hpp"
#include "support/events_in_file.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/run_folder.hpp"
#include "tactile/labels/label_runs.hpp"
#include "tactile/review/review.hpp"

namespace tactile::test {

inline review::PageRequest request(const std::string& path, const std::map<std::string, std::string>& query = {}) {
  return {.method = "GET", .path = path, .query = query, .body = ""};
}

inline std::uint32_t u32(const std::string& bytes, std::size_t index) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + 4 * index, sizeof value);
  return value;
}

/// What answers questions about a folder of runs.
class Reviewing : public ::testing::Test {
 protected:
  /// Reviews the runs of the folder.
  void review_runs(review::ReviewHelp help = {}) {
    review = std::make_unique<review::Review>(
        review::ReviewOptions{.data = "data", .models = data / "models", .studies = data.path(), .who = "ada"}, std::move(help),
        [this] { return look_for_runs(data.path()); });
  }

  /// The answer, or the refusal of a request.
  review::PageResponse ask(const review::PageRequest& asked) const {
    try {
      return review->answer(asked);
    } catch (const review::Refusal& e) {
      return review::refusal_response(e.status(), e.what());
    }
  }
  nlohmann::json json_of(const review::PageRequest& asked) const { return nlohmann::json::parse(ask(asked).body); }
  review::PageResponse post(const std::string& path, const nlohmann::json& body) const {
    return ask({.method = "POST", .path = path, .query = {}, .body = body.dump()});
  }

  /// Asks until the run is read, and waits for it.
  nlohmann::json read_run(const std::string& path) const {
    review::PageResponse answer;
    EXPECT_TRUE(comes_true([&] {
      answer = ask(request(path));
      return answer.status != 202;
    }));
    return nlohmann::json::parse(answer.body);
  }

  TemporaryFolder data;
  std::unique_ptr<review::Review> review;
};

/// A run with a press, a slip and a lift of the robot, labelled.
class ReviewingARun : public Reviewing {
 protected:
  void SetUp() override {
    run = write_made_run(data.path(), press_and_slip, lift_after_press);
    ASSERT_EQ(labels::label_runs({run}).at(0).error, "");
    events = events_in_file(run.events());
  }
  std::string version() const { return json_of(request("/api/runs/fan/01/labels")).at("version"); }
  review::PageResponse edit(const nlohmann::json& edit, const std::string& why = "") const {
    return post("/api/runs/fan/01/edits", {{"version", version()}, {"why", why}, {"edit", edit}});
  }
  std::int64_t since_first(const events::Event& event) const { return between(events.front().t, event.t).count(); }
  std::size_t count_in(std::int64_t from, std::int64_t to) const {
    return static_cast<std::size_t>(std::count_if(events.begin(), events.end(), [&](const events::Event& event) {
      return from <= since_first(event) && since_first(event) < to;
    }));
  }

  RunFolder run;
  std::vector<events::Event> events;
};

}  // namespace tactile::test
