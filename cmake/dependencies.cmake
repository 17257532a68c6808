# The libraries of the project. All are Debian packages; scripts/setup installs them.
macro(needs)
  find_package(${ARGN} REQUIRED)
endmacro()
include(library_dependencies)

# Only the compiler and the headers of FlatBuffers are used, without its CMake package, which has different names in Debian 12 and 13.
find_program(FLATC flatc REQUIRED)
find_path(FLATBUFFERS_INCLUDE_DIR flatbuffers/flatbuffers.h REQUIRED)
if(TACTILE_PYTHON)
  return()  # the rest is for training and for the programs
endif()

find_package(OpenCV REQUIRED COMPONENTS core dnn imgproc imgcodecs videoio)
find_package(CLI11 REQUIRED)
find_package(spdlog REQUIRED)
find_package(BZip2 REQUIRED)
pkg_check_modules(SQLITE REQUIRED IMPORTED_TARGET sqlite3)

if(TACTILE_SANITIZE MATCHES "thread")
  # The sanitizer ignores fences, and GCC warns of those of asio. There is always a lock as well.
  target_compile_options(tactile_asio INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-tsan>)
endif()

# Only the headers and the shared libraries of Torch are used; its CMake package also looks for the toolkits that it was built with.
find_package(Torch REQUIRED)
set(TACTILE_TORCH_VERSION "${Torch_VERSION}")

# The local page: HTTP, as Debian compiles it, and its charts, which are built into the program.
pkg_check_modules(HTTPLIB REQUIRED IMPORTED_TARGET cpp-httplib)
set(TACTILE_DYGRAPHS)
foreach(name IN ITEMS dygraph.min.js dygraph.min.css)
  find_file(DYGRAPHS_${name} ${name} PATHS /usr/share/javascript/dygraphs /usr/share/nodejs/dygraphs/dist NO_DEFAULT_PATH REQUIRED)
  list(APPEND TACTILE_DYGRAPHS ${DYGRAPHS_${name}})
endforeach()

# The camera driver is not in Debian. It is used if it is installed. Earlier versions do not know the DVXplorer Mini.
find_package(libcaer 3.3.14 QUIET)
