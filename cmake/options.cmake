# The compiler options of every target. Headers of other projects are included as SYSTEM, without warnings.
add_library(tactile_options INTERFACE)
add_library(tactile::options ALIAS tactile_options)
target_compile_features(tactile_options INTERFACE cxx_std_20)
# The libraries are also linked into shared ones, which replace none of their functions.
target_compile_options(tactile_options INTERFACE -fPIC -fno-semantic-interposition)
target_compile_options(tactile_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Wcast-align -Wformat=2 -Wconversion -Werror)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 15)
  # These compilers warn wrongly about inlined library code (GCC bugs 105562, 105329 and 105651, among others), more often with precompiled
  # headers.
  target_compile_options(tactile_options INTERFACE
    -Wno-maybe-uninitialized -Wno-restrict -Wno-array-bounds -Wno-stringop-overflow -Wno-stringop-overread)
endif()
if(CMAKE_UNITY_BUILD)
  # Files are compiled together: a name of one may be a local name of another.
  target_compile_options(tactile_options INTERFACE
    $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage> -Wno-shadow $<$<CXX_COMPILER_ID:GNU>:-Wshadow=local>)
endif()
if(TACTILE_SANITIZE)
  target_compile_options(tactile_options INTERFACE -fsanitize=${TACTILE_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(tactile_options INTERFACE -fsanitize=${TACTILE_SANITIZE})
endif()
if(TACTILE_FUZZERS)
  target_compile_options(tactile_options INTERFACE -fsanitize=fuzzer-no-link)
endif()

# Headers that many files include are parsed once for all targets that link tactile::core. Files still include the headers that they use.
set(TACTILE_PRECOMPILED_HEADERS
  <algorithm> <array> <chrono> <cmath> <cstdint> <filesystem> <fstream> <functional> <map> <memory> <numeric> <optional> <set> <span>
  <sstream> <string> <string_view> <thread> <utility> <vector> <fmt/format.h> <nlohmann/json.hpp>
  <tactile/core/json_templates.hpp>)

# For code that runs for moments only: it compiles in half the time and is a third slower.
set(TACTILE_COMPILE_QUICKLY $<$<CONFIG:Release>:-O1>)
# GCC 14 has these at -O3 and not at -O1, and then refuses the header that was precompiled at -O3.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_GREATER_EQUAL 14 AND CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64")
  list(APPEND TACTILE_COMPILE_QUICKLY $<$<CONFIG:Release>:-munroll-only-small-loops> $<$<CONFIG:Release>:-mvzeroupper>)
endif()

# The links between stages that docs/architecture.md allows, in lines "name -> stage stage …".
set(architecture ${PROJECT_SOURCE_DIR}/docs/architecture.md)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${architecture})
file(STRINGS ${architecture} arrows REGEX "^[a-z0-9_]+ ->")
foreach(arrow IN LISTS arrows)
  string(REGEX MATCH "^([a-z0-9_]+) -> *(.*)$" found "${arrow}")
  string(REPLACE " " ";" TACTILE_ARROWS_${CMAKE_MATCH_1} "${CMAKE_MATCH_2}")
endforeach()

function(check_arrows name)
  foreach(link IN LISTS ARGN)
    if(link MATCHES "^tactile::(.*)$" AND NOT CMAKE_MATCH_1 IN_LIST TACTILE_ARROWS_${name})
      message(FATAL_ERROR "stage ${name} links ${link}, which docs/architecture.md does not list; expected a stage that it allows")
    endif()
  endforeach()
endfunction()

# Leaves the sources that TACTILE_REACHED has too, and those that the build makes; or the first one, since a library needs one.
function(keep_reached list)
  set(kept "")
  foreach(source IN LISTS ${list})
    cmake_path(ABSOLUTE_PATH source OUTPUT_VARIABLE path)
    if(path IN_LIST TACTILE_REACHED OR NOT EXISTS ${path} OR path MATCHES "^${PROJECT_BINARY_DIR}/")
      list(APPEND kept ${source})
    endif()
  endforeach()
  if(NOT kept)
    list(GET ${list} 0 kept)
  endif()
  set(${list} ${kept} PARENT_SCOPE)
endfunction()

# add_stage(NAME [QUICKLY] SOURCES a.cpp … HEADERS a.hpp … LINKS tactile::core … PRIVATE_LINKS …) adds the library of a stage.
# QUICKLY compiles it with TACTILE_COMPILE_QUICKLY.
function(add_stage name)
  cmake_parse_arguments(STAGE "QUICKLY" "" "SOURCES;HEADERS;LINKS;PRIVATE_LINKS" ${ARGN})
  check_arrows(${name} ${STAGE_LINKS} ${STAGE_PRIVATE_LINKS})
  if(TACTILE_PYTHON)
    keep_reached(STAGE_SOURCES)
  endif()
  add_library(tactile_${name} STATIC)
  add_library(tactile::${name} ALIAS tactile_${name})
  target_sources(tactile_${name}
    PRIVATE ${STAGE_SOURCES}
    PUBLIC FILE_SET HEADERS BASE_DIRS ${PROJECT_SOURCE_DIR}/lib FILES ${STAGE_HEADERS})
  # Programs that link an installed library choose their own warnings.
  target_link_libraries(tactile_${name} PUBLIC $<BUILD_INTERFACE:tactile::options> ${STAGE_LINKS} PRIVATE ${STAGE_PRIVATE_LINKS})
  target_compile_features(tactile_${name} PUBLIC cxx_std_20)
  set_target_properties(tactile_${name} PROPERTIES VERIFY_INTERFACE_HEADER_SETS ON)
  if(name STREQUAL "core")
    target_precompile_headers(tactile_core PRIVATE ${TACTILE_PRECOMPILED_HEADERS})
  else()
    target_precompile_headers(tactile_${name} REUSE_FROM tactile_core)
  endif()
  if(STAGE_QUICKLY)
    target_compile_options(tactile_${name} PRIVATE ${TACTILE_COMPILE_QUICKLY})
  endif()
  if(name IN_LIST TACTILE_SEPARATE_STAGES)
    set_target_properties(tactile_${name} PROPERTIES UNITY_BUILD OFF)
  endif()
endfunction()

# add_part(NAME SOURCES a.cpp … LINKS library …) adds tactile-NAME.so, which core/loaded_part loads when it is first needed: its
# libraries take long to load. It calls functions of the program that loads it.
function(add_part name)
  cmake_parse_arguments(PART "" "" "SOURCES;LINKS" ${ARGN})
  add_library(tactile_${name} MODULE ${PART_SOURCES})
  target_link_libraries(tactile_${name} PRIVATE tactile::options ${PART_LINKS})
  target_include_directories(tactile_${name} PRIVATE ${PROJECT_SOURCE_DIR}/lib)
  set_target_properties(tactile_${name} PROPERTIES
    PREFIX "" OUTPUT_NAME tactile-${name} LIBRARY_OUTPUT_DIRECTORY ${CMAKE_RUNTIME_OUTPUT_DIRECTORY})
endfunction()
