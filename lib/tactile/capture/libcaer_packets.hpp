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

namespace tactile::capture {

// Conversion of libcaer's packets. `offset` is camera time minus device time, which the packet extends to 64 bits. Elements that
// the driver marked as invalid are left out.

/// Appends the packet's events. @return  how many are outside the sensor
std::uint64_t append_events(caerPolarityEventPacketConst packet, microseconds offset, events::SensorSize size,
                            std::vector<events::Event>& events);

void append_imu(caerIMU6EventPacketConst packet, microseconds offset, std::vector<events::ImuSample>& samples);

/// Appends the triggers of the input and of the generator. Other special events are ignored.
void append_triggers(caerSpecialEventPacketConst packet, microseconds offset, std::vector<events::Trigger>& triggers);

/// Whether the device has reset its clock to 0: a mark without time, alone in its packet.
bool has_timestamp_reset(caerEventPacketContainerConst container);

/// Time of the earliest valid element in device time [us]; nothing if there is none.
std::optional<std::int64_t> lowest_device_time(caerEventPacketContainerConst container);

}  // namespace tactile::capture
