#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "tactile/capture/camera_source.hpp"
#include "tactile/capture/packet_queue.hpp"
#include "tactile/detect/live_detector.hpp"
#include "tactile/detect/packet_supply.hpp"

namespace tactile::detect {

struct EventFeedOptions {
  /// Opens the source again after it broke; empty if that is impossible.
  std::function<std::unique_ptr<capture::CameraSource>()> open = {};
  std::chrono::milliseconds reconnect{10'000};  ///< try to open it for this long, >= 0
  /// Whether a separate thread receives packets. Otherwise `next` receives them, so that no thread has to wake another one. This
  /// needs a source that reports arrival times, since packets wait until `next` is called.
  bool receives_ahead = true;
  bool waits = false;  ///< wait for room in the queue; else packets without room are dropped and counted
  std::function<void(const capture::CameraPacket&)> see = {};  ///< called with every packet as it arrives
  /// Whether a packet must wake the thread that waits in `next`; every packet does if this is empty.
  std::function<bool(const capture::CameraPacket&)> wakes = {};
  std::function<void()> prepare = {};  ///< called first on the thread that receives packets
  ReportFault fault = [](const DetectionFault&) {};
};

/// The packets of a source until it ends. If the source breaks, a separate thread opens it again. The packets of each opening
/// have their own `source_index`. The time between two openings has one, too: an empty packet shows that the source is lost.
/// Packets wait in a queue, which is closed in the end.
class EventFeed final : public PacketSupply {
 public:
  /// @param queue  must outlive this
  EventFeed(std::unique_ptr<capture::CameraSource> source, capture::PacketQueue& queue, EventFeedOptions options);
  ~EventFeed() override;  ///< stops
  EventFeed(const EventFeed&) = delete;
  EventFeed& operator=(const EventFeed&) = delete;

  void start();
  void stop();  ///< waits for its thread, and closes the queue

  bool next(capture::PacketQueue::Packet& packet, microseconds patience, microseconds rest) override;
  void give_back(capture::PacketQueue::Packet packet) override { queue_.give_back(std::move(packet)); }
  std::uint64_t lost_events() const override { return lost_.load(std::memory_order_relaxed); }

  std::string error() const;  ///< why the source is lost; empty if it has ended
  /// How long the feed tried to open the source again before it gave up; nothing if it did not give up.
  std::optional<microseconds> gave_up_after() const;
  capture::SourceDrops drops() const;  ///< of all openings
  std::uint64_t reopened() const { return reopened_.load(std::memory_order_relaxed); }

 private:
  enum class Outcome : std::uint8_t { packet, nothing, lost, over };
  void receive_all();
  void open_when_lost();
  Outcome receive(microseconds patience);
  void mark(capture::QueuedPacket& packet) const;
  void note_arrival();
  void hand_over();
  void note_drops();
  Outcome lose(const std::string& why);
  bool open_again();
  void report(const char* kind, const std::string& text) const;

  std::unique_ptr<capture::CameraSource> source_;
  capture::PacketQueue& queue_;
  const EventFeedOptions options_;
  const std::string name_;
  const events::SensorSize sensor_;
  std::size_t index_ = 0;
  capture::PacketQueue::Packet packet_;  ///< to be filled
  bool is_lost_ = false;                 ///< the source is being opened again; unused if a separate thread receives
  std::atomic<std::uint64_t> lost_{0}, reopened_{0};
  HostTime drops_reported_{};
  std::uint64_t drops_known_ = 0;

  HostTime lost_at_{};  ///< for the thread that opens the source again

  mutable std::mutex guard_;  ///< of all that follows; only one thread writes `drops_`, and reads them without it
  std::condition_variable wake_;
  bool stops_ = false, opens_ = false;
  std::string why_lost_, error_;
  std::optional<microseconds> gave_up_after_;
  capture::SourceDrops drops_, drops_of_earlier_;
  std::thread thread_;
};

/// The first stream of events. @throws Error  if there is none, or it declares no size
const events::Stream& events_of(const capture::CameraSource& source);

}  // namespace tactile::detect
