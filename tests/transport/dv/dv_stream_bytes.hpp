#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "events/aedat4_bytes.hpp"

// DV streams byte by byte, made without the code under test.
namespace tactile::test {

/// The header: a file's without the magic line.
inline std::string stream_start(int compression, const std::string& nodes, const std::string& identifier = "IOHE") {
  return file_start(compression, xml_of(nodes), identifier).substr(14);
}

inline std::string event_stream_start(int compression = 0) {
  return stream_start(compression, event_node(0, 640, 480, "DVXplorer_DXM00001"));
}

}  // namespace tactile::test
