#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/live/live_server.hpp"

namespace tactile::cli {

/// Room on the disk of `folder`, with a warning if it is little; null if it is not known. `minutes`: for how long it lasts at the
/// pace of what is recorded.
nlohmann::json disk_json(const std::filesystem::path& folder, std::optional<double> bytes_per_s,
                         std::vector<std::string>& warnings);

/// The live page of a command whose sensor is known only once its source is open. Until then it takes events and states, and
/// shows nothing.
class LiveView {
 public:
  /// @param port  0: a free one
  explicit LiveView(std::uint16_t port) : port_(port) {}

  /// Begins to serve. @return  the page's address. @throws Error  if the port is in use
  std::string open(live::LivePageOptions options) {
    server_ = std::make_unique<live::LiveServer>(port_, std::move(options));
    page_.store(&server_->page(), std::memory_order_release);
    return server_->url();
  }

  /// By the thread of the source: never waits.
  void see(std::span<const events::Event> events) {
    if (live::LivePage* page = this->page()) page->events().add(events);
  }
  void note(std::span<const double> values) {
    if (live::LivePage* page = this->page()) page->note(values);
  }

  /// Whether a new state is due: twenty a second.
  bool is_due() {
    const auto now = std::chrono::steady_clock::now();
    if (page() == nullptr || now - published_ < std::chrono::milliseconds(50)) return false;
    published_ = now;
    return true;
  }
  void publish(nlohmann::json state) {
    if (live::LivePage* page = this->page()) page->publish(std::move(state));
  }
  void end(nlohmann::json state) {
    if (live::LivePage* page = this->page()) page->end(std::move(state));
  }

 private:
  live::LivePage* page() const { return page_.load(std::memory_order_acquire); }

  std::uint16_t port_;
  std::unique_ptr<live::LiveServer> server_;
  std::atomic<live::LivePage*> page_{nullptr};
  std::chrono::steady_clock::time_point published_{};  ///< of the thread that publishes
};

}  // namespace tactile::cli
