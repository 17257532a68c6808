#include "tactile/review/page_server.hpp"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "review/page_client.hpp"
#include "support/comes_true.hpp"
#include "support/error_of.hpp"

namespace tactile::review {
namespace {

using test::Answer;
using test::get;
using test::PageConnection;
using test::post;
using test::request_text;

constexpr std::array<WebFile, 3> files{
    {{"index.html", "<!doctype html>page"}, {"main.js", "export {};"}, {"style.css", "body {}"}}};

/// A server that answers with what it was asked.
class PageServing : public testing::Test {
 protected:
  void serve(PageServerOptions options = {}) {
    options.port = 0;
    server = std::make_unique<PageServer>(options, files, [this](const PageRequest& request) {
      ++asked;
      if (request.path == "/api/refused") throw Refusal(418, "it is a teapot; expected a cup");
      if (request.path == "/api/broken") throw Error("fan/01: no such file; expected a recording");
      return json_response(
          {{"method", request.method}, {"path", request.path}, {"query", request.query}, {"body", request.body}});
    });
    port = server->port();
  }

  std::unique_ptr<PageServer> server;
  std::uint16_t port = 0;
  std::atomic<int> asked{0};
};

TEST_F(PageServing, GivesThePageItsFilesAndTheirTypes) {
  serve();
  EXPECT_EQ(get(port, "/").body, "<!doctype html>page");
  EXPECT_EQ(get(port, "/").headers.at("content-type"), "text/html; charset=utf-8");
  EXPECT_EQ(get(port, "/web/main.js").headers.at("content-type"), "text/javascript; charset=utf-8");
  EXPECT_EQ(get(port, "/web/style.css").headers.at("content-type"), "text/css; charset=utf-8");
  EXPECT_EQ(get(port, "/web/style.css").body, "body {}");
  EXPECT_EQ(server->url(), "http://127.0.0.1:" + std::to_string(port) + "/");
}

TEST_F(PageServing, HandsRequestsOnDecoded) {
  serve();
  const Answer asked_for = get(port, "/api/runs/fan/01?at_us=5&names=a,b&x=%C3%A9%26");
  EXPECT_EQ(asked_for.status, 200);
  EXPECT_EQ(asked_for.json().at("path"), "/api/runs/fan/01");
  EXPECT_EQ(asked_for.json().at("query").at("names"), "a,b");
  EXPECT_EQ(asked_for.json().at("query").at("x"), "é&");
  const Answer posted = post(port, "/api/edits", R"({"a": 1})");
  EXPECT_EQ(posted.json().at("method"), "POST");
  EXPECT_EQ(posted.json().at("body"), R"({"a": 1})");
}

TEST_F(PageServing, AnswersSeveralRequestsOnOneConnection) {
  serve();
  PageConnection connection(port);
  for (int i = 0; i < 20; ++i) {
    connection.send(request_text(port, "GET /api/" + std::to_string(i)));
    EXPECT_EQ(connection.receive().json().at("path"), "/api/" + std::to_string(i));
  }
}

TEST_F(PageServing, NoAnswerLetsAnotherOriginIn) {
  serve();
  for (const Answer& answer : {get(port, "/"), get(port, "/web/main.js"), get(port, "/api/x"), get(port, "/api/refused"),
                               get(port, "/none"), get(port, "/api/x", "Host: evil.example\r\n"), post(port, "/api/x", "{}")}) {
    const std::string policy = answer.headers.at("content-security-policy");
    EXPECT_TRUE(policy.starts_with("default-src 'none'; script-src 'self';")) << policy;
    EXPECT_EQ(policy.find("unsafe"), std::string::npos);
    EXPECT_EQ(answer.headers.at("x-content-type-options"), "nosniff");
    EXPECT_EQ(answer.headers.at("referrer-policy"), "no-referrer");
    EXPECT_EQ(answer.headers.count("access-control-allow-origin"), 0U);
  }
  EXPECT_EQ(get(port, "/api/x").headers.at("cache-control"), "no-store");
}

TEST_F(PageServing, ErrorsAreASentence) {
  serve();
  EXPECT_EQ(get(port, "/api/refused").status, 418);
  EXPECT_EQ(get(port, "/api/refused").json().at("error"), "it is a teapot; expected a cup");
  EXPECT_EQ(get(port, "/api/broken").status, 500);
  EXPECT_EQ(get(port, "/api/broken").json().at("error"), "fan/01: no such file; expected a recording");
}

TEST_F(PageServing, NoPathLeavesTheListOfFiles) {
  serve();
  for (const char* path :
       {"/web/../../etc/passwd", "/web/..%2f..%2fetc%2fpasswd", "/web/%2e%2e/%2e%2e/etc/passwd", "/web//etc/passwd", "/web/",
        "/web", "/etc/passwd", "//etc/passwd", "/web/main.js%00.html", "/web/MAIN.JS", "/api", "/web/index.html/.."})
    EXPECT_EQ(get(port, path).status, 404) << path;
  EXPECT_EQ(asked, 0);
}

TEST_F(PageServing, OtherSitesAndHostsAreRefusedBeforeAnythingIsAsked) {
  serve();
  const std::string good_host = "Host: 127.0.0.1:" + std::to_string(port) + "\r\n";
  for (const std::string& more :
       {std::string("Host: evil.example\r\n"), "Host: evil.example:" + std::to_string(port) + "\r\n",
        std::string("Host: 127.0.0.1\r\n"), good_host + "Origin: http://evil.example\r\n", good_host + "Origin: null\r\n",
        good_host + "Sec-Fetch-Site: cross-site\r\n", good_host + "Sec-Fetch-Site: same-site\r\n"}) {
    EXPECT_EQ(get(port, "/api/x", more).status, 403) << more;
    EXPECT_EQ(get(port, "/", more).status, 403) << more;
    EXPECT_EQ(post(port, "/api/x", "{}", more).status, 403) << more;
  }
  EXPECT_EQ(asked, 0);
  EXPECT_EQ(
      get(port, "/api/x", good_host + "Origin: http://127.0.0.1:" + std::to_string(port) + "\r\nSec-Fetch-Site: same-origin\r\n")
          .status,
      200);
}

TEST_F(PageServing, OnlyGetAndPostOfJsonAreTaken) {
  serve();
  for (const char* method : {"PUT", "DELETE", "OPTIONS", "PATCH", "TRACE", "CONNECT"}) {
    PageConnection connection(port);
    connection.send(request_text(port, std::string(method) + " /api/x"));
    EXPECT_EQ(connection.receive().status, 405) << method;
  }
  const auto posted = [&](const std::string& headers, const std::string& body) {
    PageConnection connection(port);
    connection.send(request_text(port, "POST /api/x", headers, body));
    return connection.receive().status;
  };
  EXPECT_EQ(posted("Content-Type: text/plain\r\nContent-Length: 2\r\n", "{}"), 415);
  EXPECT_EQ(posted("Content-Length: 2\r\n", "{}"), 415);
  EXPECT_EQ(posted("Content-Type: application/x-www-form-urlencoded\r\nContent-Length: 3\r\n", "a=b"), 415);
  EXPECT_EQ(posted("Content-Type: application/json; charset=utf-8\r\nContent-Length: 2\r\n", "{}"), 200);
  EXPECT_EQ(posted("Content-Type: application/json\r\nTransfer-Encoding: chunked\r\n", "2\r\n{}\r\n0\r\n\r\n"), 411);
  EXPECT_EQ(posted("Content-Type: application/json\r\nContent-Encoding: gzip\r\nContent-Length: 2\r\n", "{}"), 411);
  EXPECT_EQ(posted("Content-Type: application/json\r\nContent-Length: -2\r\n", "{}"), 411);
  EXPECT_EQ(posted("Content-Type: application/json\r\nContent-Length: 2\r\nContent-Length: 3\r\n", "{}"), 411);
  EXPECT_EQ(posted("Content-Type: application/json\r\n", ""), 411);
  PageConnection with_body(port);
  with_body.send(request_text(port, "GET /api/x", "Content-Length: 2\r\n", "{}"));
  EXPECT_EQ(with_body.receive().status, 400);
  EXPECT_EQ(get(port, "/api/x", "Range: bytes=0-1\r\n").status, 400);
  EXPECT_EQ(asked, 1);
}

TEST_F(PageServing, AHugeBodyIsRefusedUnread) {
  serve({.most_body = 1000});
  EXPECT_EQ(post(port, "/api/x", std::string(1000, ' ')).status, 200);
  EXPECT_EQ(post(port, "/api/x", std::string(1001, ' ')).status, 413);
  PageConnection connection(port);
  connection.send(request_text(port, "POST /api/x", "Content-Type: application/json\r\nContent-Length: 9000000000000000000\r\n"));
  EXPECT_EQ(connection.receive().status, 413);
  PageConnection beyond(port);
  beyond.send(request_text(port, "POST /api/x", "Content-Type: application/json\r\nContent-Length: 99999999999999999999999\r\n"));
  EXPECT_EQ(beyond.receive().status, 411);
  EXPECT_EQ(asked, 1);
}

TEST_F(PageServing, HugePathsAndHeadersEndTheConnection) {
  serve();
  EXPECT_EQ(get(port, "/api/" + std::string(3000, 'a')).status, 414);
  EXPECT_NE(get(port, "/api/" + std::string(100'000, 'a')).status, 200);
  EXPECT_NE(get(port, "/api/x", "X-Long: " + std::string(100'000, 'a') + "\r\n").status, 200);
  std::string many;
  for (int i = 0; i < 5000; ++i) many += "X-Many-" + std::to_string(i) + ": 1\r\n";
  EXPECT_NE(get(port, "/api/x", many).status, 200);
  EXPECT_NE(get(port, "/api/x", "Range: bytes=" + std::string(8000, '0') + "-\r\n").status, 200);
  EXPECT_EQ(asked, 0);
  EXPECT_EQ(get(port, "/api/x").status, 200);
}

TEST_F(PageServing, WhatIsNoRequestIsAnswered400) {
  serve();
  for (const std::string text : {"GARBAGE\r\n\r\n", "GET\r\n\r\n", "GET /api/x HTTP/9.9\r\n\r\n"}) {
    PageConnection connection(port);
    connection.send(text);
    EXPECT_EQ(connection.receive().status, 400) << text;
  }
  PageConnection second_mark(port);  // a request for newer versions of cpp-httplib, but without a host
  second_mark.send("GET /api/x?a?b?c HTTP/1.1\r\n\r\n");
  EXPECT_GE(second_mark.receive().status, 400);
  PageConnection binary(port);
  binary.send(std::string("\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03\n\n\r\n\r\n", 16));
  EXPECT_NE(binary.receive().status, 200);
  EXPECT_EQ(asked, 0);
  EXPECT_EQ(get(port, "/api/x").status, 200);
}

TEST_F(PageServing, ASecondRequestIsNotHiddenInTheBodyOfARefusedOne) {
  serve();
  PageConnection connection(port);
  const std::string hidden = request_text(port, "GET /api/hidden");
  connection.send(request_text(port, "POST /api/x",
                               "Content-Type: text/plain\r\nContent-Length: " + std::to_string(hidden.size()) + "\r\n", hidden));
  EXPECT_EQ(connection.receive().status, 415);
  EXPECT_EQ(connection.receive().status, 0);
  EXPECT_EQ(asked, 0);
}

TEST_F(PageServing, ASlowClientIsDroppedThoughItSendsNowAndThen) {
  serve({.request_within = std::chrono::milliseconds(300)});
  PageConnection slow(port);
  const auto begun = std::chrono::steady_clock::now();
  std::string request = request_text(port, "GET /api/x", "X-Slow: " + std::string(2000, 'a') + "\r\n");
  std::size_t sent = 0;
  while (sent < request.size() && slow.send(request.substr(sent, 1))) {
    ++sent;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    if (std::chrono::steady_clock::now() - begun > test::long_enough) break;
  }
  EXPECT_LT(sent, request.size());  // the whole of it would take 40 s
  EXPECT_EQ(asked, 0);
}

TEST_F(PageServing, AConnectionWithoutARequestIsClosed) {
  serve({.idle = std::chrono::milliseconds(50)});
  PageConnection idle(port);
  EXPECT_TRUE(idle.is_ended());
}

TEST_F(PageServing, AHundredSilentConnectionsDoNotKeepOthersWaiting) {
  serve({.idle = std::chrono::milliseconds(600'000)});
  std::vector<std::unique_ptr<PageConnection>> silent;
  for (int i = 0; i < 100; ++i) {
    silent.push_back(std::make_unique<PageConnection>(port));
    ASSERT_TRUE(silent.back()->is_open());
    if (i % 2 == 0) silent.back()->send("GET /api/x HTTP/1.1\r\nHost:");
  }
  EXPECT_EQ(get(port, "/api/x").status, 200);
  server.reset();  // ends them all
  for (const auto& connection : silent) EXPECT_TRUE(connection->is_ended());
}

/// A server whose /api/stream counts as long as it runs, and at whose / is another file.
class PageStreaming : public testing::Test {
 protected:
  void serve(PageServerOptions options = {}) {
    options.port = 0;
    options.page = "main.js";
    server = std::make_unique<PageServer>(options, files, [this](const PageRequest& request) {
      PageResponse response{.type = "text/event-stream", .body = {}};
      const bool ends = request.query.contains("ends");
      response.parts = [this, ends, next = 0]() mutable -> std::optional<std::string> {
        ++asked;
        if (ends && next == 3) return std::nullopt;
        if (next % 2 == 1) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        return ++next % 2 == 0 && !ends ? std::string() : "data: " + std::to_string(next) + std::string(padding, ' ') + "\n\n";
      };
      return response;
    });
    port = server->port();
  }

  std::unique_ptr<PageServer> server;
  std::uint16_t port = 0;
  std::size_t padding = 0;
  std::atomic<std::uint64_t> asked{0};
};

TEST_F(PageStreaming, SendsPartsAsTheyComeAbout) {
  serve();
  EXPECT_EQ(get(port, "/").body, "export {};");
  PageConnection connection(port);
  connection.send(request_text(port, "GET /api/stream"));
  EXPECT_EQ(connection.receive().headers.at("content-type"), "text/event-stream");
  EXPECT_NE(connection.receive_until("data: 5\n").find("data: 3\n"), std::string::npos);
  EXPECT_EQ(get(port, "/api/stream", "Host: evil.example\r\n").status, 403);
}

TEST_F(PageStreaming, EndsWithItsLastPart) {
  serve();
  PageConnection connection(port);
  connection.send(request_text(port, "GET /api/stream?ends=1", "Connection: close\r\n"));
  connection.receive();
  EXPECT_NE(connection.receive_until("\r\n0\r\n\r\n").find("data: 3\n"), std::string::npos);
  EXPECT_TRUE(connection.is_ended());
}

TEST_F(PageStreaming, AsksNothingForAClientThatTakesNothing) {
  padding = 100'000;
  serve();
  PageConnection stuck(port);
  stuck.send(request_text(port, "GET /api/stream"));
  std::uint64_t before = 0;
  EXPECT_TRUE(test::comes_true([&] {  // once the system's buffers are full
    const std::uint64_t now = asked;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    return now > 0 && now == std::exchange(before, asked.load());
  }));
  EXPECT_EQ(get(port, "/").status, 200);
}

TEST_F(PageStreaming, DropsAClientThatTakesNothingForLong) {
  padding = 100'000;
  serve({.stall = std::chrono::milliseconds(100)});
  PageConnection stuck(port);
  stuck.send(request_text(port, "GET /api/stream"));
  EXPECT_TRUE(test::comes_true([&] { return asked > 0; }));
  EXPECT_TRUE(test::comes_true([&] { return !stuck.send("x"); }));
}

TEST_F(PageStreaming, EndsWithTheServerAndWithItsClient) {
  serve();
  auto leaves = std::make_unique<PageConnection>(port);
  leaves->send(request_text(port, "GET /api/stream"));
  EXPECT_TRUE(test::comes_true([&] { return asked > 0; }));
  leaves.reset();
  std::uint64_t before = 0;
  EXPECT_TRUE(test::comes_true([&] {
    const std::uint64_t now = asked;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    return now == std::exchange(before, asked.load());
  }));
  PageConnection stays(port);
  stays.send(request_text(port, "GET /api/stream"));
  stays.receive();
  server.reset();
  EXPECT_TRUE(stays.is_ended());
}

TEST_F(PageServing, AHundredClientsAtOnceAreAllAnswered) {
  serve({.most_connections = 16});
  std::atomic<int> answered{0};
  std::vector<std::thread> clients;
  clients.reserve(100);
  for (int i = 0; i < 100; ++i) {
    clients.emplace_back([&, i] {
      const Answer answer = get(port, "/api/" + std::to_string(i), "Connection: close\r\n");
      if (answer.status == 200 && answer.json().at("path") == "/api/" + std::to_string(i)) ++answered;
    });
  }
  for (std::thread& client : clients) client.join();
  EXPECT_EQ(answered, 100);
}

TEST_F(PageServing, OnLoopbackNeedsNoToken) {
  serve({.host = "localhost"});
  EXPECT_EQ(server->token(), "");
  EXPECT_EQ(get(port, "/api/x").status, 200);
}

TEST_F(PageServing, OnAnotherAddressEveryRequestNeedsTheToken) {
  serve({.host = "0.0.0.0"});
  const std::string token = server->token();
  ASSERT_EQ(token.size(), 32U);
  EXPECT_NE(server->url().find("?token=" + token), std::string::npos);
  std::string wrong = token;
  wrong.back() = wrong.back() == '0' ? '1' : '0';
  for (const char* path : {"/", "/web/main.js", "/api/x"}) {
    EXPECT_EQ(get(port, path).status, 401) << path;
    EXPECT_EQ(get(port, std::string(path) + "?token=" + wrong).status, 401) << path;
    EXPECT_EQ(get(port, std::string(path) + "?token=" + token.substr(1)).status, 401) << path;
    EXPECT_EQ(get(port, std::string(path) + "?token=" + token).status, 200) << path;
    EXPECT_EQ(get(port, path, "X-Tactile-Token: " + token + "\r\n").status, 200) << path;
  }
  EXPECT_EQ(post(port, "/api/x", "{}").status, 401);
  EXPECT_EQ(post(port, "/api/x", "{}", "X-Tactile-Token: " + token + "\r\n").status, 200);
}

TEST_F(PageServing, TheCookieOpensTheFilesAndNothingElse) {
  serve({.host = "0.0.0.0"});
  const std::string set = get(port, "/?token=" + server->token()).headers.at("set-cookie");
  EXPECT_NE(set.find("HttpOnly"), std::string::npos);
  EXPECT_NE(set.find("SameSite=Strict"), std::string::npos);
  const std::string cookie = "Cookie: other=1; " + set.substr(0, set.find(';')) + "\r\n";
  EXPECT_EQ(get(port, "/", cookie).status, 200);
  EXPECT_EQ(get(port, "/web/main.js", cookie).status, 200);
  EXPECT_EQ(get(port, "/api/x", cookie).status, 401);
  EXPECT_EQ(post(port, "/api/x", "{}", cookie).status, 401);
}

TEST_F(PageServing, APortThatIsTakenIsNamed) {
  serve();
  PageServerOptions same;
  same.port = port;
  EXPECT_EQ(
      test::error_of([&] { const PageServer second(same, files, [](const PageRequest&) { return PageResponse{}; }); }),
      "127.0.0.1:" + std::to_string(port) + ": another program uses this port; expected a free one, such as any by --port 0");
}

TEST_F(PageServing, ListensAgainRightAfterItsEnd) {
  serve();
  get(port, "/api/x");
  const std::uint16_t same = port;
  server.reset();
  PageServerOptions options;
  options.port = same;
  server = std::make_unique<PageServer>(options, files, [](const PageRequest&) { return PageResponse{}; });
  EXPECT_EQ(get(same, "/").status, 200);
}

TEST_F(PageServing, FinishesAnAnswerBeforeItEnds) {
  std::atomic<bool> is_asked{false}, may_answer{false};
  PageServerOptions options;
  options.port = 0;
  auto waiting = std::make_unique<PageServer>(options, files, [&](const PageRequest&) {
    is_asked = true;
    while (!may_answer) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return json_response({{"done", true}});
  });
  PageConnection connection(waiting->port());
  connection.send(request_text(waiting->port(), "POST /api/x", "Content-Type: application/json\r\nContent-Length: 2\r\n", "{}"));
  ASSERT_TRUE(test::comes_true([&] { return is_asked.load(); }));
  std::thread ends([&] { waiting.reset(); });
  may_answer = true;
  ends.join();
  EXPECT_TRUE(connection.is_ended());
}

}  // namespace
}  // namespace tactile::review
