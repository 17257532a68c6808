#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "tactile/review/page_message.hpp"

namespace tactile::review {

/// A file of the page, built into the program.
struct WebFile {
  std::string_view name;  ///< "index.html"
  std::string_view content;
};

struct PageServerOptions {
  std::string host = "127.0.0.1";                    ///< to listen on; any but a loopback one needs a token
  std::uint16_t port = 7790;                         ///< 0: a free one
  std::string page = "index.html";                   ///< the file that "/" is
  std::size_t most_body = 65'536;                    ///< [B] of a request
  std::size_t most_connections = 256;                ///< at once; more wait
  std::chrono::milliseconds request_within{10'000};  ///< a request must have arrived, from its first byte on
  std::chrono::milliseconds stall{10'000};           ///< a client that takes no byte of an answer for this long is dropped
  std::chrono::milliseconds idle{5'000};             ///< a connection without a request is closed
};

/// Serves a page and its files to browsers, and hands its requests on. It knows nothing of what the page shows.
///
/// Every request must be for this host, from this page itself (`why_foreign`), with GET, HEAD or POST; a POST has JSON of at most
/// `most_body`. A server on another address than a loopback one has a random token: `url()` holds it, `GET /?token=` puts it into
/// a cookie for the files, and every path below /api needs it in the header X-Tactile-Token, or as ?token=. No answer allows
/// another origin anything, and the content security policy allows no inline script. An answer of `PageParts` ends with the
/// server, or when its client leaves or takes nothing for `stall`.
class PageServer {
 public:
  /// Called on several threads at once. A `Refusal` has its own status, another `Error` 500; both become {"error": sentence}.
  using Answer = std::function<PageResponse(const PageRequest&)>;

  /// Listens when it returns, and answers on its own threads.
  /// @param files   "/" is `options.page`, "/web/NAME" any of them; they must outlive the server
  /// @param answer  of paths below /api
  /// @throws Error  if the address cannot be listened on
  PageServer(PageServerOptions options, std::span<const WebFile> files, Answer answer);
  ~PageServer();  ///< ends all connections; answers that are being made are finished first, but not those of parts
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  std::uint16_t port() const;
  const std::string& token() const;  ///< empty where none is needed
  std::string url() const;           ///< for a browser, with the token

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile::review
