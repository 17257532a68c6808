#include "tactile/capture/network_source.hpp"

#include "tactile/capture/camera_streams.hpp"
#include "tactile/events/simulated_recording.hpp"
#include "tactile/transport/dv/dv_stream_client.hpp"

namespace tactile::capture {
namespace {

class NetworkSource final : public CameraSource {
 public:
  explicit NetworkSource(const std::string& address)
      : name_(address), client_(transport::network_address(address)), stream_(client_.stream()) {}

  std::string name() const override { return name_; }
  std::span<const events::Stream> streams() const override { return {&stream_, 1}; }
  bool simulated() const override { return events::is_simulated(streams()); }
  bool reports_arrivals() const override { return client_.reports_arrivals(); }
  bool can_reopen() const override { return true; }
  nlohmann::json camera() const override {
    nlohmann::json json = camera_json(streams());
    json["stream"] = client_.address().text();
    return json;
  }

  Received receive(CameraPacket& packet, std::chrono::microseconds patience) override {
    switch (client_.receive(patience)) {
      case transport::DvStreamClient::Received::closed:
        return Received::ended;
      case transport::DvStreamClient::Received::nothing:
        return Received::nothing;
      case transport::DvStreamClient::Received::packet:
        break;
    }
    packet.clear();
    packet.stream_id = stream_.id;
    const std::span<const events::Event> events = client_.events();
    packet.events.assign(events.begin(), events.end());
    packet.imu.assign(client_.imu().begin(), client_.imu().end());
    packet.triggers.assign(client_.triggers().begin(), client_.triggers().end());
    packet.frame = client_.frame();
    packet.arrived = client_.arrived();
    packet.more_came = client_.more_came();
    times_.keep(packet, name_, backward_);
    return Received::packet;
  }

  SourceDrops drops() const override {
    const transport::DvStreamProblems& problems = client_.problems();
    SourceDrops drops = backward_;
    drops.packets += problems.broken_packets + problems.mismatched_packets + problems.foreign_packets;
    drops.events += problems.out_of_range_events;
    return drops;
  }

 private:
  std::string name_;
  transport::DvStreamClient client_;
  events::Stream stream_;
  AscendingTimes times_;
  SourceDrops backward_;  ///< elements back in time
};

}  // namespace

std::unique_ptr<CameraSource> open_network_source(const std::string& address) { return std::make_unique<NetworkSource>(address); }

}  // namespace tactile::capture
