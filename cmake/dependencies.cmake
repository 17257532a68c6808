# The libraries of the project. All are Debian packages; scripts/setup installs them.
find_package(Threads REQUIRED)
find_package(PkgConfig REQUIRED)
find_package(CLI11 REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(spdlog REQUIRED)
find_package(fmt REQUIRED)
find_package(pugixml REQUIRED)
find_package(OpenSSL REQUIRED COMPONENTS Crypto)
find_package(Eigen3 REQUIRED NO_MODULE)
find_package(OpenCV REQUIRED COMPONENTS core imgproc imgcodecs videoio)
find_package(HDF5 REQUIRED COMPONENTS C)
find_package(ZLIB REQUIRED)
find_package(BZip2 REQUIRED)
pkg_check_modules(LZ4 REQUIRED IMPORTED_TARGET liblz4)
pkg_check_modules(ZSTD REQUIRED IMPORTED_TARGET libzstd)
pkg_check_modules(SQLITE REQUIRED IMPORTED_TARGET sqlite3)
pkg_check_modules(HWY REQUIRED IMPORTED_TARGET libhwy)
pkg_check_modules(LIBAV REQUIRED IMPORTED_TARGET libavformat libavcodec libavutil libswscale)

# Asio without Boost consists of headers only. Only the stages that link this target include them.
find_path(ASIO_INCLUDE_DIR asio.hpp REQUIRED)
add_library(tactile_asio INTERFACE)
target_include_directories(tactile_asio SYSTEM INTERFACE ${ASIO_INCLUDE_DIR})
target_compile_definitions(tactile_asio INTERFACE ASIO_STANDALONE ASIO_NO_DEPRECATED)
target_link_libraries(tactile_asio INTERFACE Threads::Threads)
if(TACTILE_SANITIZE MATCHES "thread")
  # The sanitizer ignores fences, and GCC warns of those of asio. There is always a lock as well.
  target_compile_options(tactile_asio INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-tsan>)
endif()

# Only the messages of ONNX are used, without its CMake package, whose targets have different names in Debian 12 and 13.
find_package(Protobuf REQUIRED)
find_path(ONNX_INCLUDE_DIR onnx/onnx_pb.h REQUIRED)
find_library(ONNX_PROTO_LIBRARY onnx_proto REQUIRED)
add_library(tactile_onnx INTERFACE)
target_include_directories(tactile_onnx SYSTEM INTERFACE ${ONNX_INCLUDE_DIR})
target_compile_definitions(tactile_onnx INTERFACE ONNX_ML=1 ONNX_NAMESPACE=onnx)
target_link_libraries(tactile_onnx INTERFACE ${ONNX_PROTO_LIBRARY} protobuf::libprotobuf)

# Only the C interface of XGBoost is used, and only to fit trees.
find_path(XGBOOST_INCLUDE_DIR xgboost/c_api.h REQUIRED)
find_library(XGBOOST_LIBRARY xgboost REQUIRED)
add_library(tactile_xgboost INTERFACE)
target_include_directories(tactile_xgboost SYSTEM INTERFACE ${XGBOOST_INCLUDE_DIR})
target_link_libraries(tactile_xgboost INTERFACE ${XGBOOST_LIBRARY})

# Only the compiler and the headers of FlatBuffers are used, without its CMake package, which has different names in Debian 12 and 13.
find_program(FLATC flatc REQUIRED)
find_path(FLATBUFFERS_INCLUDE_DIR flatbuffers/flatbuffers.h REQUIRED)

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
