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

namespace tactile {

struct EventFeedOptions {
  /// Opens the source again after it broke; one that cannot be opened again, such as a file, has none.
  std::function<std::unique_ptr<CameraSource>()> open = {};
  std::chrono::milliseconds reconnect{10'000};  ///< how long it is tried, >= 0
  /// Whether a thread of its own receives; else whoever asks for the next packet does, which spares waking one thread by another.
  /// That is for sources that tell when packets arrived, since they lie until they are asked for.
  bool receives_ahead = true;
  bool waits = false;                                 ///< for room in the queue; else what finds none is dropped and counted
  std::function<void(const CameraPacket&)> see = {};  ///< shown every packet as it comes
  /// Whether a packet is worth waking who takes them from the queue; each is if this is empty.
  std::function<bool(const CameraPacket&)> wakes = {};
  std::function<void()> prepare = {};  ///< done first on the thread that receives ahead
  TellFault fault = {};
};

/// Brings what a source sends until it ends, and opens the source again where it broke, on a thread of its own. Each opening has a
/// `source_index` of its own, and so has each time between two: then one empty packet tells that the source is gone. What waits
/// to be asked for is in a queue, which is closed when it is over.
class EventFeed final : public PacketSupply {
 public:
  /// @param queue  must outlive this
  EventFeed(std::unique_ptr<CameraSource> source, PacketQueue& queue, EventFeedOptions options);
  ~EventFeed() override;  ///< stops
  EventFeed(const EventFeed&) = delete;
  EventFeed& operator=(const EventFeed&) = delete;

  void start();
  void stop();  ///< waits for what its thread is busy with, and closes the queue

  bool next(PacketQueue::Packet& packet, microseconds patience, microseconds rest) override;
  void give_back(PacketQueue::Packet packet) override { queue_.give_back(std::move(packet)); }
  std::uint64_t lost_events() const override { return lost_.load(std::memory_order_relaxed); }

  std::string error() const;  ///< why the source is gone for good; empty where it ended by itself
  /// How long it was tried to open the source again before that was given up; nothing if it was not given up.
  std::optional<microseconds> gave_up_after() const;
  SourceDrops drops() const;  ///< of all openings
  std::uint64_t reopened() const { return reopened_.load(std::memory_order_relaxed); }

 private:
  enum class Outcome : std::uint8_t { packet, nothing, gone, over };
  void receive_all();
  void open_when_gone();
  Outcome receive(microseconds patience);
  void mark(QueuedPacket& packet) const;
  void note_arrival();
  void hand_over();
  void note_drops();
  Outcome leave(const std::string& why);
  bool open_again();
  void say(const char* kind, const std::string& text) const;

  std::unique_ptr<CameraSource> source_;
  PacketQueue& queue_;
  const EventFeedOptions options_;
  const std::string name_;
  const SensorSize sensor_;
  std::size_t index_ = 0;
  PacketQueue::Packet packet_;  ///< to be filled
  bool is_gone_ = false;        ///< the source, and so it is being opened; not where it is received ahead
  std::atomic<std::uint64_t> lost_{0}, reopened_{0};
  HostTime drops_told_{};
  std::uint64_t drops_known_ = 0;

  HostTime gone_at_{};  ///< once it is, for whoever opens it

  mutable std::mutex guard_;  ///< of all that follows; one thread alone writes `drops_`, and reads them without it
  std::condition_variable wake_;
  bool stops_ = false, opens_ = false;
  std::string why_gone_, error_;
  std::optional<microseconds> gave_up_after_;
  SourceDrops drops_, drops_of_earlier_;
  std::thread thread_;
};

/// The first stream of events. @throws Error  if there is none, or it declares no size
const Stream& events_of(const CameraSource& source);

}  // namespace tactile
