# What every target of ours is compiled with; other people's headers come in as SYSTEM and stay out of it.
add_library(tactile_options INTERFACE)
add_library(tactile::options ALIAS tactile_options)
target_compile_features(tactile_options INTERFACE cxx_std_20)
target_compile_options(tactile_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Wcast-align -Wformat=2 -Werror)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 15)
  # Both see dangers in inlined library code that are not there (GCC bugs 105562 and 105329, among others).
  target_compile_options(tactile_options INTERFACE -Wno-maybe-uninitialized -Wno-restrict)
endif()
if(TACTILE_SANITIZE)
  target_compile_options(tactile_options INTERFACE -fsanitize=${TACTILE_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(tactile_options INTERFACE -fsanitize=${TACTILE_SANITIZE})
endif()
if(TACTILE_FUZZERS)
  target_compile_options(tactile_options INTERFACE -fsanitize=fuzzer-no-link)
endif()

# add_stage(NAME SOURCES a.cpp … HEADERS a.hpp … LINKS tactile::core … PRIVATE_LINKS …): one library per stage of the way.
function(add_stage name)
  cmake_parse_arguments(STAGE "" "" "SOURCES;HEADERS;LINKS;PRIVATE_LINKS" ${ARGN})
  add_library(tactile_${name} STATIC)
  add_library(tactile::${name} ALIAS tactile_${name})
  target_sources(tactile_${name}
    PRIVATE ${STAGE_SOURCES}
    PUBLIC FILE_SET HEADERS BASE_DIRS ${PROJECT_SOURCE_DIR}/lib FILES ${STAGE_HEADERS})
  target_link_libraries(tactile_${name} PUBLIC tactile::options ${STAGE_LINKS} PRIVATE ${STAGE_PRIVATE_LINKS})
  set_target_properties(tactile_${name} PROPERTIES VERIFY_INTERFACE_HEADER_SETS ON)
endfunction()
