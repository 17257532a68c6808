# What the libraries of tactile need that other C++ programs may link (docs/cpp.md). It is also a part of the installed package, so that
# find_package(tactile) finds the same. Whoever includes it defines needs(), which finds a package.
needs(Threads)
needs(PkgConfig)
needs(nlohmann_json)
needs(fmt)
needs(pugixml)
needs(OpenSSL COMPONENTS Crypto)
needs(Eigen3 NO_MODULE)
needs(OpenCV COMPONENTS core imgproc)
needs(HDF5 COMPONENTS C)
needs(ZLIB)
pkg_check_modules(DEFLATE REQUIRED QUIET IMPORTED_TARGET libdeflate)
pkg_check_modules(LZ4 REQUIRED QUIET IMPORTED_TARGET liblz4)
pkg_check_modules(ZSTD REQUIRED QUIET IMPORTED_TARGET libzstd)
pkg_check_modules(HWY REQUIRED QUIET IMPORTED_TARGET libhwy)
pkg_check_modules(LIBAV REQUIRED QUIET IMPORTED_TARGET libavformat libavcodec libavutil libswscale)

# Asio without Boost consists of headers only. Only the stages that link this target include them. Targets of this file are imported:
# an installed library refers to them by name.
find_path(ASIO_INCLUDE_DIR asio.hpp REQUIRED)
if(NOT TARGET tactile_asio)
  add_library(tactile_asio INTERFACE IMPORTED)
  target_include_directories(tactile_asio SYSTEM INTERFACE ${ASIO_INCLUDE_DIR})
  target_compile_definitions(tactile_asio INTERFACE ASIO_STANDALONE ASIO_NO_DEPRECATED)
  target_link_libraries(tactile_asio INTERFACE Threads::Threads)
endif()

# Only the messages of ONNX are used, without its CMake package, whose targets have different names in Debian 12 and 13.
needs(Protobuf)
find_path(ONNX_INCLUDE_DIR onnx/onnx_pb.h REQUIRED)
find_library(ONNX_PROTO_LIBRARY onnx_proto REQUIRED)
if(NOT TARGET tactile_onnx)
  add_library(tactile_onnx INTERFACE IMPORTED)
  target_include_directories(tactile_onnx SYSTEM INTERFACE ${ONNX_INCLUDE_DIR})
  target_compile_definitions(tactile_onnx INTERFACE ONNX_ML=1 ONNX_NAMESPACE=onnx)
  target_link_libraries(tactile_onnx INTERFACE ${ONNX_PROTO_LIBRARY} protobuf::libprotobuf)
endif()
