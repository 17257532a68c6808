#include <gtest/gtest.h>

#include <atomic>
#include <cstring>
#include <fstream>
#include <thread>

#include "review/reviewing.hpp"
#include "support/comes_true.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/labels/label_runs.hpp"
#include "tactile/review/review.hpp"
#include "windows/made_runs.hpp"

namespace tactile::review {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::request;
using test::ReviewingARun;

TEST_F(ReviewingARun, ProbabilitiesComeFromTheModelThatIsAskedFor) {
  std::atomic<bool> may_end{false};
  fs::create_directories(data / "models/net");
  std::ofstream(data / "models/net/model.json") << "{}";
  review_runs({.classify =
                   [&](const fs::path&, const fs::path& bundle, const std::function<void(std::size_t)>& advance) {
                     EXPECT_EQ(bundle.filename(), "net");
                     while (!may_end) {
                       advance(1);
                       std::this_thread::sleep_for(std::chrono::milliseconds(1));
                     }
                     results::FullRun full;
                     full.ticks = {.first = after(events.front().t, 40ms), .count = 2, .tick = 2ms};
                     full.probabilities = {{0.5F, 0.25F, 0.25F}, {0.0F, 0.0F, 1.0F}};
                     return full;
                   },
               .default_model = [] { return std::optional<std::string>("net"); },
               .draw_labels = {}});
  const json run_json = read_run("/api/runs/fan/01");
  EXPECT_EQ(run_json.at("default_model"), "net");
  EXPECT_EQ(run_json.at("models"), json::array({"net"}));
  const auto asked = [&](const std::string& model) {
    return ask(
        request("/api/runs/fan/01/signals", {{"from_us", "0"}, {"to_us", "3000000"}, {"names", "p_slip"}, {"model", model}}));
  };
  EXPECT_EQ(json::parse(asked("net").body).at("pending"), json::array({"p_slip"}));
  EXPECT_EQ(asked("../net").status, 404);
  EXPECT_EQ(asked("other").status, 404);
  may_end = true;
  ASSERT_TRUE(test::comes_true([&] { return json::parse(asked("net").body).at("pending").empty(); }));
  const json slip = json::parse(asked("net").body).at("series").at("p_slip");
  EXPECT_EQ(slip.at("t_us"), json::array({40'000, 42'000}));
  EXPECT_EQ(slip.at("mean"), json::array({0.25, 1.0}));
}

TEST_F(ReviewingARun, ProbabilitiesOfAModelThatIsTrainedAgainAreComputedAgain) {
  fs::create_directories(data / "models/net");
  const auto write_model = [&](const std::string& text) {
    std::ofstream(data / "models/net/new.json") << text;
    fs::rename(data / "models/net/new.json", data / "models/net/model.json");
  };
  write_model("1");
  std::atomic<int> asked{0};
  std::atomic<bool> was_ended{false};
  review_runs({.classify =
                   [&](const fs::path&, const fs::path&, const std::function<void(std::size_t)>& advance) {
                     results::FullRun full;
                     full.ticks = {.first = after(events.front().t, 40ms), .count = 1, .tick = 2ms};
                     full.probabilities = {{0.0F, 0.0F, asked == 0 ? 0.25F : 0.5F}};
                     if (asked++ == 0) {
                       try {
                         while (true) {
                           advance(1);
                           std::this_thread::sleep_for(std::chrono::milliseconds(1));
                         }
                       } catch (...) {
                         was_ended = true;
                         throw;
                       }
                     }
                     return full;
                   },
               .default_model = {},
               .draw_labels = {}});
  read_run("/api/runs/fan/01");
  const PageRequest slip =
      request("/api/runs/fan/01/signals", {{"from_us", "0"}, {"to_us", "3000000"}, {"names", "p_slip"}, {"model", "net"}});
  ask(slip);
  ASSERT_TRUE(test::comes_true([&] { return asked == 1; }));
  write_model("2");
  ASSERT_TRUE(test::comes_true([&] { return json_of(slip).at("pending").empty(); }));
  EXPECT_TRUE(was_ended);
  EXPECT_EQ(json_of(slip).at("series").at("p_slip").at("mean"), json::array({0.5}));
}

TEST_F(ReviewingARun, OfManyModelsTheLastOnesAreKept) {
  std::vector<std::string> names;
  for (int i = 0; i < 12; ++i) {
    names.push_back("net-" + std::to_string(i));
    fs::create_directories(data / "models" / names.back());
    std::ofstream(data / "models" / names.back() / "model.json") << "{}";
  }
  std::atomic<int> asked{0};
  review_runs({.classify =
                   [&](const fs::path&, const fs::path&, const std::function<void(std::size_t)>&) {
                     ++asked;
                     return results::FullRun{};
                   },
               .default_model = {},
               .draw_labels = {}});
  read_run("/api/runs/fan/01");
  const auto answered = [&](const std::string& name) {
    const PageRequest slip =
        request("/api/runs/fan/01/signals", {{"from_us", "0"}, {"to_us", "10"}, {"names", "p_slip"}, {"model", name}});
    return test::comes_true([&] { return json_of(slip).at("pending").empty(); });
  };
  for (const std::string& name : names) ASSERT_TRUE(answered(name)) << name;
  EXPECT_EQ(asked, 12);
  ASSERT_TRUE(answered(names.back()));
  EXPECT_EQ(asked, 12);
}

TEST_F(ReviewingARun, EndsWhileAModelStillPredicts) {
  fs::create_directories(data / "models/net");
  std::ofstream(data / "models/net/model.json") << "{}";
  std::atomic<bool> has_begun{false};
  review_runs(
      {.classify = [&](const fs::path&, const fs::path&, const std::function<void(std::size_t)>& advance) -> results::FullRun {
         has_begun = true;
         while (true) {
           advance(1);
           std::this_thread::sleep_for(std::chrono::milliseconds(1));
         }
       },
       .default_model = {},
       .draw_labels = {}});
  read_run("/api/runs/fan/01");
  ask(request("/api/runs/fan/01/signals", {{"from_us", "0"}, {"to_us", "10"}, {"names", "p_slip"}, {"model", "net"}}));
  ASSERT_TRUE(test::comes_true([&] { return has_begun.load(); }));
  review.reset();
}

}  // namespace
}  // namespace tactile::review
