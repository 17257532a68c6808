#pragma once

#include <libcaer/events/imu6.h>
#include <libcaer/events/packetContainer.h>
#include <libcaer/events/polarity.h>
#include <libcaer/events/special.h>

#include <cstdint>
#include <optional>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/events/other_streams.hpp"

namespace tactile {

// From libcaer's packets to ours. `offset` is camera time minus the device's, which the packet extends to 64 bits; elements that
// the driver marked as invalid are left out.

/// Appends the packet's events; returns how many lay outside the sensor.
std::uint64_t append_events(caerPolarityEventPacketConst packet, microseconds offset, SensorSize size,
                            std::vector<Event>& events);

void append_imu(caerIMU6EventPacketConst packet, microseconds offset, std::vector<ImuSample>& samples);

/// Appends the signals at the trigger input and the generator's; every other special event is the driver's own business.
void append_triggers(caerSpecialEventPacketConst packet, microseconds offset, std::vector<Trigger>& triggers);

/// Whether the device has set its clock back to 0: a mark that comes alone, and bears no time.
bool has_timestamp_reset(caerEventPacketContainerConst container);

/// The earliest valid element's time on the device's clock [us]; nothing if there is none.
std::optional<std::int64_t> lowest_device_time(caerEventPacketContainerConst container);

}  // namespace tactile
