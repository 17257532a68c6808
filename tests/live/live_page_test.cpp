#include "tactile/live/live_page.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "live/live_client.hpp"
#include "support/error_of.hpp"
#include "tactile/live/live_server.hpp"

namespace tactile::live {
namespace {

using nlohmann::json;
using test::get;
using test::LiveClient;
using test::PageConnection;
using test::post;
using test::request_text;

constexpr events::SensorSize sensor{40, 30};

class LivePages : public testing::Test {
 protected:
  LivePages() : server(0, {.sensor = sensor, .values = {"p_press"}}), port(test::port_in(server.url())) {}

  /// A millisecond of a stream: one event brighter at (3, 2), one darker at (5, 4).
  void add_ms() {
    const std::vector<events::Event> events{{.t = camera_time(1'000 * ms), .x = 3, .y = 2, .on = 1},
                                            {.t = camera_time(1'000 * ms + 500), .x = 5, .y = 4, .on = 0}};
    server.page().events().add(events);
    ++ms;
  }

  LiveServer server;
  std::uint16_t port;
  std::int64_t ms = 0;
};

TEST_F(LivePages, ServeTheLivePageOnThisMachine) {
  EXPECT_TRUE(server.url().starts_with("http://127.0.0.1:")) << server.url();
  EXPECT_NE(get(port, "/").body.find("/web/live.js"), std::string::npos);
  EXPECT_EQ(get(port, "/web/live.js").status, 200);
  EXPECT_EQ(get(port, "/api/runs").status, 404);
  EXPECT_EQ(get(port, "/api/live", "Host: evil.example\r\n").status, 403);
  EXPECT_EQ(get(port, "/api/live", "Origin: http://evil.example\r\n").status, 403);
  EXPECT_EQ(get(port, "/api/live/events", "Sec-Fetch-Site: cross-site\r\n").status, 403);
}

TEST_F(LivePages, TellTheNewestStateAndTheStepsOfTheLastMinute) {
  server.page().publish({{"run", "fan/01"}});
  server.page().publish({{"run", "fan/02"}});
  LiveClient client(port);
  EXPECT_EQ(client.head().headers.at("content-type"), "text/event-stream");
  const json first = client.next_where([](const json& m) { return !m.at("state").is_null(); });
  EXPECT_EQ(first.at("state").at("run"), "fan/02");
  EXPECT_EQ(first.at("columns"), json({"events_per_s", "p_press"}));
  EXPECT_FALSE(first.at("ended"));
  server.page().note(std::vector{0.25});
  server.page().note(std::vector{0.75});
  server.page().note(std::vector{0.5});
  std::vector<double> times;
  for (const json& step : first.at("steps")) times.push_back(step.at(0));
  const json noted = client.next_where([&](const json& m) {
    for (const json& step : m.at("steps")) times.push_back(step.at(0));
    const json& steps = m.at("steps");
    return std::any_of(steps.begin(), steps.end(), [](const json& step) { return step.at(2) == 0.75; });
  });
  EXPECT_FALSE(noted.is_null()) << "the highest value of a step is shown";
  for (std::size_t i = 1; i < times.size(); ++i) EXPECT_GT(times[i], times[i - 1]) << "no step comes twice";
}

TEST_F(LivePages, ShowPicturesOfTheNewestEventsOnlyWhileSomeoneLooks) {
  for (int i = 0; i < 300; ++i) add_ms();
  EXPECT_EQ(get(port, "/api/live/events").status, 204);
  LiveClient client(port);
  std::atomic<bool> stops{false};
  std::thread adds([&] {
    while (!stops) {
      add_ms();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  const json message = client.next_where([](const json& m) { return m.at("live").at("picture") >= 2; });
  const std::string bytes = get(port, "/api/live/events").body;  // after a silence, there would be none in the picture
  stops = true;
  adds.join();
  ASSERT_FALSE(message.is_null());
  EXPECT_EQ(message.at("live").at("picture_us"), 40'000);
  EXPECT_GT(message.at("live").at("rate_per_s"), 0);
  ASSERT_EQ(bytes.size(), 16U + 2 * 40 * 30);
  EXPECT_EQ(bytes.substr(0, 8), std::string("\x28\0\0\0\x1e\0\0\0", 8));
  EXPECT_EQ(static_cast<int>(bytes[16 + 2 * 40 + 3]), 40);             // one brighter event in each of 40 ms
  EXPECT_EQ(static_cast<int>(bytes[16 + 40 * 30 + 4 * 40 + 5]), 40);   // and one darker
  EXPECT_EQ(get(port, "/api/live/heatmap").body.size(), 16U + 8 * 6);  // a fifth of either side
}

TEST_F(LivePages, TakeAChoiceOnlyWhereItIsAsked) {
  EXPECT_EQ(post(port, "/api/live/choice", R"({"question": 1, "choice": "start"})").status, 404) << "this page offers none";
  std::vector<std::string> chosen;
  const LiveServer asks(0, {.sensor = sensor, .choose = [&](std::uint64_t question, const std::string& choice) {
                              if (question == 7) chosen.push_back(choice);
                              return question == 7;
                            }});
  const std::uint16_t its_port = test::port_in(asks.url());
  EXPECT_EQ(post(its_port, "/api/live/choice", R"({"question": 7, "choice": "start"})").status, 200);
  const auto late = post(its_port, "/api/live/choice", R"({"question": 6, "choice": "start"})");
  EXPECT_EQ(late.status, 409);
  EXPECT_EQ(late.json().at("error"), "this was no longer asked, so nothing was done");
  for (const char* body : {"", "[]", "{}", R"({"question": -7, "choice": "start"})", R"({"question": 7, "choice": 3})",
                           R"({"question": "7", "choice": "start"})", R"({"question": 7.5, "choice": "start"})"})
    EXPECT_EQ(post(its_port, "/api/live/choice", body).status, 400) << body;
  EXPECT_EQ(post(its_port, "/api/live/choice", R"({"question": 7, "choice": "stop"})", "Origin: http://evil.example\r\n").status,
            403);
  EXPECT_EQ(chosen, std::vector<std::string>{"start"});
}

TEST_F(LivePages, AnEmptyPictureFollowsASilence) {
  LiveClient client(port);
  const json message = client.next_where([](const json& m) { return m.at("live").at("picture") >= 1; });
  ASSERT_FALSE(message.is_null());
  const std::string bytes = get(port, "/api/live/events").body;
  EXPECT_EQ(bytes.find_first_not_of('\0', 8), std::string::npos);
}

TEST_F(LivePages, EventsOutsideTheSensorAreLeftOut) {
  LiveClient client(port);
  std::atomic<bool> stops{false};
  std::thread adds([&] {
    for (std::int64_t t = 0; !stops; t += 10'000) {
      server.page().events().add(std::vector<events::Event>{{.t = camera_time(t), .x = 40, .y = 0, .on = 1},
                                                            {.t = camera_time(t), .x = -1, .y = 29, .on = 1},
                                                            {.t = camera_time(t), .x = 39, .y = 29, .on = 1}});
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  });
  // The first pictures may be older than the events. Here is the count of pixel (39, 29), in each of its 40 ms one event.
  const auto count_of_events = [&] {
    const std::string bytes = get(port, "/api/live/events").body;
    return bytes.size() > 16 ? static_cast<int>(bytes[8]) : 0;
  };
  EXPECT_TRUE(test::comes_true([&] { return count_of_events() == 4; })) << count_of_events();
  stops = true;
  adds.join();
}

TEST_F(LivePages, AClientThatTakesNothingDelaysNobody) {
  json large;
  for (int i = 0; i < 20'000; ++i) large.push_back("a state that is larger than others");
  PageConnection stuck(port);
  stuck.send(request_text(port, "GET /api/live"));
  const auto begun = std::chrono::steady_clock::now();
  std::chrono::steady_clock::duration longest{};
  while (std::chrono::steady_clock::now() - begun < std::chrono::seconds(3)) {
    json state = large;
    const auto before = std::chrono::steady_clock::now();
    server.page().publish(std::move(state));
    server.page().note(std::vector{0.5});
    add_ms();
    longest = std::max(longest, std::chrono::steady_clock::now() - before);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  // The client's connection is full after a second or so. Whoever waited for it would wait for ten seconds.
  EXPECT_LT(longest, std::chrono::seconds(5));
  LiveClient reads(port);
  EXPECT_FALSE(reads.next().is_null());
}

TEST_F(LivePages, TheLastStateReachesWhoLooksOnAndEndsTheStream) {
  LiveClient client(port);
  client.next();
  server.page().end({{"state", "ended"}});
  const json last = client.next_where([](const json& m) { return m.at("ended").get<bool>(); });
  ASSERT_FALSE(last.is_null());
  EXPECT_EQ(last.at("state").at("state"), "ended");
  EXPECT_TRUE(client.next().is_null()) << "nothing follows it";
}

TEST(LiveServing, APortThatIsTakenIsNamed) {
  const LiveServer first(0, {.sensor = sensor});
  const auto port = test::port_in(first.url());
  EXPECT_NE(test::error_of([&] { const LiveServer second(port, {.sensor = sensor}); }).find("another program uses this port"),
            std::string::npos);
}

}  // namespace
}  // namespace tactile::live
