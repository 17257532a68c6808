#pragma once

namespace tactile::events {

/// The upper four bits of a word of EVT3. Source: Prophesee, EVT 3.0 Format, docs.prophesee.ai.
struct Evt3Word {
  enum : unsigned {
    address_y = 0x0,
    address_x = 0x2,
    vector_base_x = 0x3,
    vector_12 = 0x4,
    vector_8 = 0x5,
    time_low = 0x6,
    continued_4 = 0x7,
    time_high = 0x8,
    external_trigger = 0xA,
    others = 0xE,
    continued_12 = 0xF
  };
};

}  // namespace tactile::events
