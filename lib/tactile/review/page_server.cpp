#include "tactile/review/page_server.hpp"

#include <fmt/core.h>
#include <httplib.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "tactile/core/error.hpp"
#include "tactile/core/error_text.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/text.hpp"
#include "tactile/review/page_connection.hpp"
#include "tactile/review/request_checks.hpp"

// This file and page_connection.hpp are the only ones that include httplib. Its members differ between Debian 12 (0.11) and 13
// (0.18); both are met here.
namespace tactile::review {
namespace {

using SteadyClock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr std::size_t longest_target = 2048;   // [B] of a request: path and query
constexpr std::size_t most_requests = 10'000;  // of one connection
constexpr const char* policy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; connect-src 'self'; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'none'";

thread_local Connection* current = nullptr;  // whose request this thread answers

/// A thread for each connection, as many as are needed and allowed.
class ConnectionThreads final : public httplib::TaskQueue {
 public:
  explicit ConnectionThreads(std::size_t most) : most_(most) {}

  using Taken = decltype(std::declval<httplib::TaskQueue&>().enqueue(std::declval<std::function<void()>>()));

  Taken enqueue(std::function<void()> connection) override {
    {
      const std::scoped_lock lock(guard_);
      waiting_.push_back(std::move(connection));
      if (idle_ < waiting_.size() && threads_.size() < most_) threads_.emplace_back([this] { serve(); });
    }
    changed_.notify_one();
    return Taken(true);  // a bool in newer versions, else void
  }

  void shutdown() override {
    {
      const std::scoped_lock lock(guard_);
      ends_ = true;
    }
    changed_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }

 private:
  void serve() {
    std::unique_lock lock(guard_);
    while (true) {
      ++idle_;
      changed_.wait(lock, [&] { return ends_ || !waiting_.empty(); });
      --idle_;
      if (waiting_.empty()) return;
      const std::function<void()> connection = std::move(waiting_.front());
      waiting_.pop_front();
      lock.unlock();
      connection();
      lock.lock();
    }
  }

  std::mutex guard_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> waiting_;
  std::vector<std::thread> threads_;
  std::size_t most_, idle_ = 0;
  bool ends_ = false;
};

/// httplib's parser and its answers, on connections of our own.
class HttpServer final : public httplib::Server {
 public:
  explicit HttpServer(const PageServerOptions& options) : options_(options) {
    new_task_queue = [most = options.most_connections] { return new ConnectionThreads(most); };
    set_payload_max_length(options.most_body);
    // Without SO_REUSEPORT, by which a second server could listen on the same port.
    set_socket_options([](socket_t socket) {
      const int on = 1;
      ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    });
  }

  /// @return  the port; 0 if it cannot listen
  std::uint16_t bind() {
    errno = 0;
    int port = options_.port;
    if (port == 0) {
      port = bind_to_any_port(options_.host);
    } else if (!bind_to_port(options_.host, port)) {
      port = 0;
    }
    if (port <= 0) return 0;
    ::listen(svr_sock_, SOMAXCONN);  // httplib's own queue holds five connections
    return static_cast<std::uint16_t>(port);
  }

  void start() {
    listens_ = std::thread([this] { listen_after_bind(); });
    while (!is_running()) std::this_thread::sleep_for(milliseconds{1});
  }

  void end() {
    ends_ = true;
    stop();
    listens_.join();
  }

 private:
  bool process_and_close_socket(socket_t socket) override {
    const int on = 1;
    ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    Connection connection(socket, options_, ends_);
    current = &connection;
    bool is_whole = true;
    for (std::size_t i = 0; i < most_requests && is_whole && connection.wait_for_request(); ++i) {
      bool closes = false;
      is_whole = process(*this, connection, i + 1 == most_requests, closes) && !closes && !connection.closes();
    }
    current = nullptr;
    connection.end();
    return is_whole;
  }

  template <class Server>
  static bool process(Server& server, Connection& connection, bool is_last, bool& closes) {
    if constexpr (requires { server.process_request(connection, is_last, closes, nullptr); }) {
      return server.process_request(connection, is_last, closes, nullptr);
    } else {
      return server.process_request(connection, std::string(), 0, std::string(), 0, is_last, closes, nullptr);
    }
  }

  const PageServerOptions& options_;
  std::atomic<bool> ends_{false};
  std::thread listens_;
};

std::string_view type_of(std::string_view name) {
  const std::size_t dot = name.rfind('.');
  const std::string_view extension = dot == std::string_view::npos ? "" : name.substr(dot);
  if (extension == ".html") return "text/html; charset=utf-8";
  if (extension == ".js") return "text/javascript; charset=utf-8";
  if (extension == ".css") return "text/css; charset=utf-8";
  if (extension == ".svg") return "image/svg+xml";
  if (extension == ".png") return "image/png";
  return "application/octet-stream";
}

PageRequest page_request(const httplib::Request& request) {
  PageRequest asked{
      .method = request.method == "HEAD" ? "GET" : request.method, .path = request.path, .query = {}, .body = request.body};
  for (const auto& [name, value] : request.params) asked.query.emplace(name, value);
  return asked;
}

/// Sends the next part. @return  false if the connection is to end
bool send_part(const PageParts& parts, httplib::DataSink& sink) {
  while (current->wait_for_room()) {
    const std::optional<std::string> part = parts();
    if (part && part->empty()) continue;
    if (part) return sink.write(part->data(), part->size());
    sink.done();
    return true;
  }
  return false;
}

std::string machine_name() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

}  // namespace

struct PageServer::State {
  State(PageServerOptions with, std::span<const WebFile> with_files, Answer with_answer)
      : options(std::move(with)), files(with_files), answer(std::move(with_answer)), http(options) {}

  PageServerOptions options;
  std::span<const WebFile> files;
  Answer answer;
  std::uint16_t port = 0;
  std::string token, machine = machine_name();
  HttpServer http;

  /// Refuses what must not be answered, and answers what has no body. A refusal may come before the request is read to its end.
  httplib::Server::HandlerResponse before_the_body(const httplib::Request& request, httplib::Response& response) const {
    if (const auto refused = refusal_of(request)) {
      current->close_after_this();
      send(*refused, response);
      return httplib::Server::HandlerResponse::Handled;
    }
    if (request.method == "POST") {
      current->take_body();
      return httplib::Server::HandlerResponse::Unhandled;
    }
    send(answer_to(request), response);
    return httplib::Server::HandlerResponse::Handled;
  }

  std::optional<PageResponse> refusal_of(const httplib::Request& request) const;
  std::optional<PageResponse> refusal_of_body(const httplib::Request& request) const;
  bool has_token(const httplib::Request& request) const;
  PageResponse answer_to(const httplib::Request& request) const;
  PageResponse file_response(const httplib::Request& request) const;

  static void send(const PageResponse& answer, httplib::Response& response) {
    response.status = answer.status;
    if (answer.parts) {
      current->begin_parts();
      response.set_chunked_content_provider(
          answer.type, [parts = answer.parts](std::size_t, httplib::DataSink& sink) { return send_part(parts, sink); });
    } else if (answer.status != 204) {
      response.set_content(answer.body, answer.type);
    }
    bool is_cached = false;
    for (const auto& [name, value] : answer.headers) {
      response.set_header(name, value);
      is_cached = is_cached || name == "Cache-Control";
    }
    if (!is_cached) response.set_header("Cache-Control", "no-store");
  }
};

std::optional<PageResponse> PageServer::State::refusal_of(const httplib::Request& request) const {
  if (request.target.size() > longest_target)
    return refusal_response(414, "the request's path is too long; expected one of this page");
  const RequestOrigin from{.host = request.get_header_value("Host"),
                           .origin = request.get_header_value("Origin"),
                           .sec_fetch_site = request.get_header_value("Sec-Fetch-Site")};
  if (const std::string why = why_foreign(from, options.host, port, machine); !why.empty()) return refusal_response(403, why);
  if (request.method != "GET" && request.method != "HEAD" && request.method != "POST")
    return refusal_response(405, "the request's method is " + shown_text(request.method) + "; expected GET or POST");
  if (request.has_header("Range")) return refusal_response(400, "the request asks for a part; expected one for the whole");
  if (auto refused = refusal_of_body(request)) return refused;
  if (!token.empty() && !has_token(request))
    return refusal_response(401, "the request has no token, or a wrong one; expected the address that 'tactile' printed");
  return std::nullopt;
}

std::optional<PageResponse> PageServer::State::refusal_of_body(const httplib::Request& request) const {
  const std::string length = request.get_header_value("Content-Length");
  if (request.has_header("Transfer-Encoding") || request.has_header("Content-Encoding"))
    return refusal_response(411, "the request's body is encoded; expected plain JSON with its Content-Length");
  if (request.method != "POST") {
    if (length.empty() || length == "0") return std::nullopt;
    return refusal_response(400, "the request has a body; expected none");
  }
  const auto bytes = whole_number_in(length);
  if (!bytes || *bytes < 0 || request.get_header_value_count("Content-Length") != 1)
    return refusal_response(411, "the request's Content-Length is no number; expected the size of its body");
  if (static_cast<std::uint64_t>(*bytes) > options.most_body)
    return refusal_response(413, fmt::format("the request's body is too large; expected at most {} bytes", options.most_body));
  const std::string type = request.get_header_value("Content-Type");
  if (trimmed(std::string_view(type).substr(0, type.find(';'))) != "application/json")
    return refusal_response(415, "the request's body is " + shown_text(type) + "; expected application/json");
  return std::nullopt;
}

bool PageServer::State::has_token(const httplib::Request& request) const {
  if (same_secret(request.get_header_value("X-Tactile-Token"), token)) return true;
  if (same_secret(request.get_param_value("token"), token)) return true;
  // A browser adds a cookie by itself, whoever asks. Therefore it opens the page's files only.
  return !request.path.starts_with("/api") &&
         same_secret(cookie_in(request.get_header_value("Cookie"), fmt::format("tactile-{}", port)), token);
}

PageResponse PageServer::State::answer_to(const httplib::Request& request) const {
  try {
    if (!request.path.starts_with("/api/")) return file_response(request);
    return answer(page_request(request));
  } catch (const Refusal& e) {
    return refusal_response(e.status(), e.what());
  } catch (const std::exception& e) {
    return refusal_response(500, sentence_of(e));
  }
}

PageResponse PageServer::State::file_response(const httplib::Request& request) const {
  const std::string_view path = request.path;
  constexpr std::string_view folder = "/web/";
  const std::string_view name = path == "/"                ? std::string_view(options.page)
                                : path.starts_with(folder) ? path.substr(folder.size())
                                                           : "";
  const auto file = std::find_if(files.begin(), files.end(), [&](const WebFile& one) { return one.name == name; });
  if (request.method == "POST" || name.empty() || file == files.end())
    throw Refusal(404, "there is no " + shown_text(path) + "; expected a part of this page");
  PageResponse response{.status = 200, .type = std::string(type_of(name)), .body = std::string(file->content)};
  response.headers.emplace_back("Cache-Control", "no-cache");
  if (path == "/" && !token.empty())
    response.headers.emplace_back("Set-Cookie", fmt::format("tactile-{}={}; Path=/; HttpOnly; SameSite=Strict", port, token));
  return response;
}

PageServer::PageServer(PageServerOptions options, std::span<const WebFile> files, Answer answer)
    : state_(std::make_unique<State>(std::move(options), files, std::move(answer))) {
  State& state = *state_;
  if (!is_loopback(state.options.host)) state.token = random_token();
  state.http.set_default_headers({{"Content-Security-Policy", policy},
                                  {"X-Content-Type-Options", "nosniff"},
                                  {"Referrer-Policy", "no-referrer"},
                                  {"Cross-Origin-Resource-Policy", "same-origin"}});
  state.http.set_pre_routing_handler([&state](const httplib::Request& request, httplib::Response& response) {
    return state.before_the_body(request, response);
  });
  state.http.Post(".*", [&state](const httplib::Request& request, httplib::Response& response) {
    State::send(state.answer_to(request), response);
  });
  state.http.set_error_handler(httplib::Server::Handler([](const httplib::Request&, httplib::Response& response) {
    if (response.body.empty()) {
      current->close_after_this();
      State::send(refusal_response(response.status, "the request cannot be read; expected one of this page"), response);
    }
  }));
  state.port = state.http.bind();
  if (state.port == 0) {
    const std::string address = fmt::format("{}:{}", state.options.host, state.options.port);
    if (errno == EADDRINUSE)
      throw Error(address + ": another program uses this port; expected a free one, such as any by --port 0");
    throw Error(address + ": cannot be listened on; expected an address of this machine, and a port that this user may use");
  }
  state.http.start();
}

PageServer::~PageServer() { state_->http.end(); }

std::uint16_t PageServer::port() const { return state_->port; }
const std::string& PageServer::token() const { return state_->token; }

std::string PageServer::url() const {
  std::string host = is_any_address(state_->options.host) ? state_->machine : state_->options.host;
  if (host.find(':') != std::string::npos) host = "[" + host + "]";
  return fmt::format("http://{}:{}/{}", host, state_->port, state_->token.empty() ? "" : "?token=" + state_->token);
}

}  // namespace tactile::review
