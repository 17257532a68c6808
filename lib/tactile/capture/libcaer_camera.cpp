#include "tactile/capture/libcaer_camera.hpp"

#include <fmt/core.h>
#include <libcaer/devices/device_discover.h>
#include <libcaer/devices/dvxplorer.h>
#include <libcaer/libcaer.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <cstdlib>
#include <mutex>
#include <string_view>

#include "tactile/capture/camera_streams.hpp"
#include "tactile/capture/dv_bridge.hpp"
#include "tactile/capture/libcaer_packets.hpp"
#include "tactile/capture/readout_mode.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/host_clock.hpp"
#include "tactile/events/recording_writer.hpp"

// Earlier versions do not support the DVXplorer Mini, invert its polarity, or cannot stop and start its read-out.
static_assert(LIBCAER_VERSION >= 30314, "libcaer is too old; expected 3.3.14 or later");

namespace tactile::capture {
namespace {

constexpr std::int32_t imu_stream = 2, trigger_stream = 3;  // ids as in DV
constexpr std::uint32_t container_interval_us = 1000;
constexpr std::uint32_t waiting_containers = 4096;  ///< 4 s; the ring's size is a power of two
constexpr std::string_view lost_container = "Dropped EventPacket Container";

/// The driver's messages. It sends them from any of its threads, for the whole process.
class DriverLog {
 public:
  static DriverLog& instance() {
    static DriverLog log;
    return log;
  }

  std::uint64_t lost_containers() const { return lost_; }
  void forget_complaint() {
    const std::scoped_lock lock(guard_);
    complaint_.clear();
  }
  std::string complaint() const {
    const std::scoped_lock lock(guard_);
    return complaint_;
  }

 private:
  DriverLog() {
    caerLogLevelSet(CAER_LOG_NOTICE);  // lost containers are reported at this level
    caerLogFileDescriptorsSet(-1, -1);
    caerLogCallbackSet([](const char* message, std::size_t length) { instance().add({message, length}); });
  }

  void add(std::string_view message) {
    if (message.find(lost_container) != std::string_view::npos) {
      ++lost_;
      return;
    }
    // "TIME: LEVEL: WHO: WHAT\n"
    if (const auto what = message.rfind(": "); what != std::string_view::npos) message.remove_prefix(what + 2);
    while (!message.empty() && (message.back() == '\n' || message.back() == '.' || message.back() == '\0'))
      message.remove_suffix(1);
    const std::scoped_lock lock(guard_);
    complaint_ = message;
  }

  std::atomic<std::uint64_t> lost_{0};
  mutable std::mutex guard_;
  std::string complaint_;
};

bool is_mini(const caer_dvx_info& info) { return !info.muxHasStatistics && !info.dvsHasStatistics && !info.extInputHasGenerator; }

std::string description_of(const caer_dvx_info& info) {
  return fmt::format("{} {}, firmware {}, {}x{}", is_mini(info) ? "DVXplorer Mini" : "DVXplorer", info.deviceSerialNumber,
                     info.firmwareVersion, info.dvsSizeX, info.dvsSizeY);
}

std::vector<caer_device_discovery_result> discover() {
  DriverLog::instance();
  caerDeviceDiscoveryResult found = nullptr;
  const ssize_t count = caerDeviceDiscover(CAER_DEVICE_DVXPLORER, &found);
  const std::unique_ptr<caer_device_discovery_result, decltype(&std::free)> owner(found, &std::free);
  if (count <= 0 || found == nullptr) return {};
  return {found, found + count};
}

void refuse_foreign_firmware(const std::string& name, const caer_dvx_info& info) {
  if (info.firmwareVersion < first_foreign_firmware) return;
  throw Error(
      fmt::format("{}: {} has firmware {}, which libcaer does not support; expected one below {}, or the camera served by "
                  "{} and --from tcp://127.0.0.1:7777",
                  name, info.deviceSerialNumber, info.firmwareVersion, first_foreign_firmware, dv_bridge()));
}

/// The chosen camera. @throws Error  if there is none, or more than one
caer_dvx_info choose(const std::string& name, const std::optional<std::string>& serial) {
  std::vector<caer_device_discovery_result> chosen;
  std::string all;
  for (const caer_device_discovery_result& found : discover()) {
    const std::string own = found.deviceInfo.dvXplorerInfo.deviceSerialNumber;
    all += (all.empty() ? "" : ", ") + (own.empty() ? "one of unknown serial number" : own);
    if (!serial || own == *serial) chosen.push_back(found);
  }
  if (all.empty())
    throw Error(name + ": no DVXplorer was found; expected one at the USB, or another source (tactile record --list)");
  if (chosen.empty()) throw Error(name + ": no such DVXplorer; expected one of " + all);
  if (chosen.size() > 1) throw Error(name + ": several DVXplorers were found; expected camera:SERIAL with one of " + all);
  const caer_device_discovery_result& only = chosen.front();
  const caer_dvx_info& info = only.deviceInfo.dvXplorerInfo;
  refuse_foreign_firmware(name, info);
  if (only.deviceErrorVersion)
    throw Error(
        fmt::format("{}: libcaer refuses firmware {} or logic {} of this camera; expected it updated with the vendor's tools",
                    name, info.firmwareVersion, info.logicVersion));
  if (only.deviceErrorOpen)
    throw Error(name +
                ": the camera cannot be opened; expected permission (the vendor's udev rules), and no other program that "
                "uses it");
  return info;
}

struct CloseDevice {
  void operator()(caer_device_handle* device) const {
    caerDeviceHandle handle = device;
    caerDeviceClose(&handle);
  }
};
using Device = std::unique_ptr<caer_device_handle, CloseDevice>;

struct FreeContainer {
  void operator()(caer_event_packet_container* container) const { caerEventPacketContainerFree(container); }
};
using Container = std::unique_ptr<caer_event_packet_container, FreeContainer>;

class LibcaerCamera final : public CameraSource {
 public:
  LibcaerCamera(std::string name, const std::optional<std::string>& serial, const ReadoutMode& mode)
      : name_(std::move(name)), mode_(mode), lost_before_(DriverLog::instance().lost_containers()) {
    const caer_dvx_info wanted = choose(name_, serial);
    DriverLog::instance().forget_complaint();
    device_.reset(caerDeviceOpen(1, CAER_DEVICE_DVXPLORER, wanted.deviceUSBBusNumber, wanted.deviceUSBDeviceAddress,
                                 wanted.deviceSerialNumber));
    if (!device_) fail("cannot be opened");
    info_ = caerDVXplorerInfoGet(device_.get());
    refuse_foreign_firmware(name_, info_);
    size_ = {info_.dvsSizeX, info_.dvsSizeY};
    configure();
    declare_streams();
    start();
  }
  ~LibcaerCamera() override { caerDeviceDataStop(device_.get()); }
  LibcaerCamera(const LibcaerCamera&) = delete;
  LibcaerCamera& operator=(const LibcaerCamera&) = delete;

  std::string name() const override { return name_; }
  std::span<const events::Stream> streams() const override { return streams_; }
  bool can_reopen() const override { return true; }

  nlohmann::json camera() const override {
    nlohmann::json json = camera_json(streams_);
    json["model"] = is_mini(info_) ? "DVXplorer Mini" : "DVXplorer";
    json["serial"] = info_.deviceSerialNumber;
    json["firmware"] = info_.firmwareVersion;
    json["logic"] = info_.logicVersion;
    json["chip"] = info_.chipID;
    json["driver"] = std::string("libcaer ") + LIBCAER_VERSION_STRING;
    json["sensitivity"] = "default";
    json["container_interval_us"] = container_interval_us;
    json["readout"] = {
        {"fixed_read_time", mode_.fixed_read_time}, {"wait_us", mode_.wait_us}, {"next_select", mode_.next_select}};
    if (mode_.fixed_read_time) json["readout"]["read_cycles"] = mode_.read_cycles;
    if (offset_) json["ts_offset_us"] = offset_->count();
    return json;
  }

  Received receive(CameraPacket& packet, std::chrono::microseconds patience) override {
    const auto until = std::chrono::steady_clock::now() + patience;
    packet.clear();
    for (;;) {
      while (container_) {
        if (next_packet_ == caerEventPacketContainerGetEventPacketsNumber(container_.get())) {
          container_.reset();
        } else if (translate(caerEventPacketContainerGetEventPacketConst(container_.get(), next_packet_++), packet)) {
          return Received::packet;
        }
      }
      if (!next_container(until)) return Received::nothing;
    }
  }

  SourceDrops drops() const override {
    SourceDrops drops = drops_;
    drops.packets += DriverLog::instance().lost_containers() - lost_before_;
    return drops;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    const std::string complaint = DriverLog::instance().complaint();
    throw Error(name_ + ": " + what + (complaint.empty() ? "" : " (" + complaint + ")") +
                "; expected a DVXplorer that no other program uses");
  }

  void set(std::int8_t module, std::uint8_t parameter, std::uint32_t value, const char* what) {
    if (!caerDeviceConfigSet(device_.get(), module, parameter, value)) fail(std::string("rejects its setting of ") + what);
  }

  void configure() {
    DriverLog::instance().forget_complaint();
    if (!caerDeviceSendDefaultConfig(device_.get())) fail("rejects its default settings");
    set(CAER_HOST_CONFIG_PACKETS, CAER_HOST_CONFIG_PACKETS_MAX_CONTAINER_INTERVAL, container_interval_us, "the packets' length");
    set(CAER_HOST_CONFIG_DATAEXCHANGE, CAER_HOST_CONFIG_DATAEXCHANGE_BUFFER_SIZE, waiting_containers, "the driver's buffer");
    // A Mini has no module for triggers: all settings there fail.
    if (!is_mini(info_)) {
      set(DVX_EXTINPUT, DVX_EXTINPUT_DETECT_RISING_EDGES, 1, "its signal input");
      set(DVX_EXTINPUT, DVX_EXTINPUT_DETECT_FALLING_EDGES, 1, "its signal input");
      set(DVX_EXTINPUT, DVX_EXTINPUT_DETECT_PULSES, 0, "its signal input");
    }
    set(DVX_DVS_CHIP, DVX_DVS_CHIP_DTAG_CONTROL, DVX_DVS_CHIP_DTAG_CONTROL_STOP, "the read-out");
    set(DVX_DVS_CHIP, DVX_DVS_CHIP_FIXED_READ_TIME_ENABLE, mode_.fixed_read_time ? 1 : 0, "the read-out");
    set(DVX_DVS_CHIP, DVX_DVS_CHIP_TIMING_ED, mode_.wait_us, "the read-out");
    set(DVX_DVS_CHIP, DVX_DVS_CHIP_TIMING_NEXT_SEL, mode_.next_select, "the read-out");
    if (mode_.fixed_read_time) set(DVX_DVS_CHIP, DVX_DVS_CHIP_TIMING_READ_FIXED, mode_.read_cycles, "the read-out");
    set(DVX_DVS_CHIP, DVX_DVS_CHIP_DTAG_CONTROL, DVX_DVS_CHIP_DTAG_CONTROL_START, "the read-out");
  }

  void declare_streams() {
    const std::string source = std::string("DVXplorer_") + info_.deviceSerialNumber;
    streams_.push_back(events::event_stream_declaration(size_, source));
    const auto add = [&](std::int32_t id, events::StreamType type, const char* identifier) {
      events::Stream& stream = streams_.emplace_back();
      stream.id = id;
      stream.type = type;
      stream.type_identifier = identifier;
      stream.source = source;
      stream.name = name_of(type);
    };
    if (info_.imuType != IMU_NONE) add(imu_stream, events::StreamType::imu, "IMUS");
    if (!is_mini(info_)) add(trigger_stream, events::StreamType::triggers, "TRIG");
    times_.resize(streams_.size());
    set_info(streams_.front(), readout_mode_attribute, std::string(mode_.name));
  }

  void start() {
    // The driver's own wait polls every millisecond, for one second only. Therefore its callback wakes this thread.
    const auto wake = [](void* self) {
      auto* camera = static_cast<LibcaerCamera*>(self);
      { const std::scoped_lock lock(camera->guard_); }
      camera->something_new_.notify_one();
    };
    const auto gone = [](void* self) {
      auto* camera = static_cast<LibcaerCamera*>(self);
      {
        const std::scoped_lock lock(camera->guard_);
        camera->unplugged_ = true;
      }
      camera->something_new_.notify_one();
    };
    const auto ignore = [](void*) {};
    if (!caerDeviceDataStart(device_.get(), wake, ignore, this, gone, this)) fail("does not start");
  }

  /// Takes the driver's next container with known packets; false if none arrives in time.
  bool next_container(std::chrono::steady_clock::time_point until) {
    for (;;) {
      Container container(caerDeviceDataGet(device_.get()));
      if (!container) {
        std::unique_lock lock(guard_);
        if (unplugged_) throw Error(name_ + ": camera unplugged, or its USB connection broke; expected it to stay connected");
        // Checked again while the lock is held, so that no wake-up is missed.
        container.reset(caerDeviceDataGet(device_.get()));
        if (!container) {
          if (something_new_.wait_until(lock, until) == std::cv_status::timeout) return false;
          continue;
        }
      }
      if (has_timestamp_reset(container.get())) {
        offset_.reset();
        continue;
      }
      if (!offset_) {
        const std::optional<std::int64_t> lowest = lowest_device_time(container.get());
        if (lowest) offset_ = microseconds{us_of(host_now()) - *lowest};
        continue;
      }
      container_ = std::move(container);
      next_packet_ = 0;
      return true;
    }
  }

  /// False if the packet has no known elements.
  bool translate(caerEventPacketHeaderConst from, CameraPacket& packet) {
    if (from == nullptr) return false;
    switch (caerEventPacketHeaderGetEventType(from)) {
      case POLARITY_EVENT:
        packet.stream_id = 0;
        drops_.events += append_events(caerPolarityEventPacketFromPacketHeaderConst(from), *offset_, size_, packet.events);
        break;
      case IMU6_EVENT:
        packet.stream_id = imu_stream;
        append_imu(caerIMU6EventPacketFromPacketHeaderConst(from), *offset_, packet.imu);
        break;
      case SPECIAL_EVENT:
        packet.stream_id = trigger_stream;
        append_triggers(caerSpecialEventPacketFromPacketHeaderConst(from), *offset_, packet.triggers);
        break;
      default:
        return false;
    }
    for (std::size_t i = 0; i < streams_.size(); ++i) {
      if (streams_[i].id != packet.stream_id) continue;
      times_[i].keep(packet, name_, drops_);
      return !packet.empty();
    }
    packet.clear();  // of a type that this model does not have
    return false;
  }

  std::string name_;
  ReadoutMode mode_;
  std::uint64_t lost_before_;
  caer_dvx_info info_{};
  events::SensorSize size_;
  std::vector<events::Stream> streams_;
  std::vector<AscendingTimes> times_;
  std::optional<microseconds> offset_;  ///< camera time minus the device's
  SourceDrops drops_;                   ///< without those that the driver lost

  std::mutex guard_;
  std::condition_variable something_new_;
  bool unplugged_ = false;
  Device device_;  ///< last: its threads use the other members
  Container container_;
  std::int32_t next_packet_ = 0;
};

}  // namespace

bool is_built_with_libcaer() { return true; }

std::unique_ptr<CameraSource> open_libcaer_camera(const std::string& name, const std::optional<std::string>& serial,
                                                  const std::string& mode) {
  return std::make_unique<LibcaerCamera>(name, serial, readout_mode(mode.empty() ? default_readout_mode : mode));
}

std::vector<FoundSource> find_libcaer_cameras() {
  std::vector<FoundSource> cameras;
  for (const caer_device_discovery_result& found : discover()) {
    const caer_dvx_info& info = found.deviceInfo.dvXplorerInfo;
    if (found.deviceErrorOpen || found.deviceErrorVersion || info.firmwareVersion >= first_foreign_firmware) continue;
    cameras.push_back({std::string("camera:") + info.deviceSerialNumber, description_of(info), info.deviceSerialNumber});
  }
  return cameras;
}

}  // namespace tactile::capture
