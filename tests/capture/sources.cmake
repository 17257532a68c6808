# The sources behind CameraSource; what the recorder makes of them has tests of its own.
set(TRANSLATION_TESTS)
if(TARGET libcaer::caer)
  set(TRANSLATION_TESTS libcaer_packets_test.cpp)
endif()
add_stage_tests(capture_sources
  SOURCES
    camera_source_test.cpp camera_streams_test.cpp file_source_test.cpp find_sources_test.cpp network_source_test.cpp
    simulator_source_test.cpp ${TRANSLATION_TESTS}
  LINKS tactile::capture tactile::transport_dv tactile::simulation)
if(TARGET libcaer::caer)
  target_link_libraries(capture_sources_tests PRIVATE libcaer::caer)
endif()
