#include "tactile/live/live_server.hpp"

#include <utility>

#include "tactile/review/web_files.hpp"

namespace tactile::live {
namespace {

review::PageServerOptions server_options(std::uint16_t port) {
  review::PageServerOptions options;
  options.port = port;
  options.page = "live.html";
  return options;
}

}  // namespace

LiveServer::LiveServer(std::uint16_t port, LivePageOptions options)
    : page_(std::move(options)), server_(server_options(port), review::web_files(), [this](const review::PageRequest& request) {
        return page_.answer(request);
      }) {}

}  // namespace tactile::live
