#pragma once

#include <hdf5.h>

#include <string_view>
#include <utility>

#include "tactile/events/stream.hpp"

namespace tactile::conversion::hdf5_layout {

inline constexpr hsize_t chunk_rows = 65'536;

/// The name of each type's group, in the order in which the types are read.
inline constexpr std::pair<events::StreamType, std::string_view> groups[] = {
    {events::StreamType::events, "events"}, {events::StreamType::imu, "imu"}, {events::StreamType::triggers, "triggers"}};

}  // namespace tactile::conversion::hdf5_layout
