#pragma once

#include <string>

namespace tactile {

/// The system clock's time in UTC: "2024-05-31T12:00:00.000000Z".
std::string now_utc();

}  // namespace tactile
