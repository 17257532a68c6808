# The Debian packages, which scripts/package makes: `tactile` with the program, and `tactile-dev` with the libraries for C++ programs.
execute_process(COMMAND dpkg --print-architecture OUTPUT_VARIABLE architecture OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME tactile)
set(CPACK_PACKAGE_CONTACT "The tactile developers <tactile@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL program development)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_PACKAGE_SECTION science)

set(CPACK_COMPONENT_PROGRAM_DESCRIPTION "This is the command-line program: it records and simulates runs, labels
them, trains and evaluates models, and detects press and slip live.")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME tactile)
set(CPACK_DEBIAN_PROGRAM_FILE_NAME tactile_${PROJECT_VERSION}_${architecture}.deb)
# dpkg-shlibdeps finds the packages of every library that the programs load, with their lowest versions.
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS "gnuplot-nox | gnuplot")  # draws labels.png and the figures
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "python3")               # for share/tactile/scripts
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS "libopenblas0-pthread")  # otherwise libtorch may use a BLAS that takes two to three times as long

set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "These are the libraries for C++ programs: they read recordings, render
heatmaps, and predict press and slip with a trained model.")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME tactile-dev)
set(CPACK_DEBIAN_DEVELOPMENT_FILE_NAME tactile-dev_${PROJECT_VERSION}_${architecture}.deb)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
# What library_dependencies.cmake finds.
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "cmake (>= 3.25), pkg-config, nlohmann-json3-dev, libfmt-dev, libpugixml-dev, libssl-dev, libeigen3-dev, libopencv-dev, libhdf5-dev, zlib1g-dev, libdeflate-dev, liblz4-dev, libzstd-dev, libhwy-dev, libavformat-dev, libavcodec-dev, libavutil-dev, libswscale-dev, libasio-dev, libonnx-dev, libprotobuf-dev")
include(CPack)
