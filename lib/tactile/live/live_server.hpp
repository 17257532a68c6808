#pragma once

#include <cstdint>
#include <string>

#include "tactile/live/live_page.hpp"
#include "tactile/review/page_server.hpp"

namespace tactile::live {

/// Serves the live page on this machine alone, until it is destroyed.
class LiveServer {
 public:
  /// @param port  0: a free one. @throws Error  if it is in use; as `LivePage`
  LiveServer(std::uint16_t port, LivePageOptions options);

  LivePage& page() { return page_; }
  std::string url() const { return server_.url(); }

 private:
  LivePage page_;
  review::PageServer server_;
};

}  // namespace tactile::live
