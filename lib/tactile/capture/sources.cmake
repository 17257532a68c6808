# What CameraSource stands for: files, streams, the simulator, and cameras where the build found their driver.
if(TARGET libcaer::caer)
  set(CAMERA_SOURCES libcaer_camera.cpp libcaer_packets.cpp)
  set(CAMERA_LIBRARY libcaer::caer)
else()
  set(CAMERA_SOURCES no_libcaer_camera.cpp)
  set(CAMERA_LIBRARY)
endif()
target_sources(tactile_capture
  PRIVATE
    camera_source.cpp camera_streams.cpp dv_bridge.cpp file_source.cpp find_sources.cpp network_source.cpp pace.cpp readout_mode.cpp simulator_source.cpp
    ${CAMERA_SOURCES}
  PUBLIC FILE_SET HEADERS FILES
    camera_streams.hpp dv_bridge.hpp file_source.hpp find_sources.hpp found_source.hpp libcaer_camera.hpp network_source.hpp pace.hpp readout_mode.hpp
    simulator_source.hpp)
target_link_libraries(tactile_capture PRIVATE tactile::transport_dv tactile::simulation ${CAMERA_LIBRARY})
