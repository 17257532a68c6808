# What `cmake --install` installs, in two parts: the program, and the libraries for other C++ programs.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# The program. `tactile` finds the others in ../libexec/tactile (apps/tactile/program.cpp).
install(TARGETS tactile RUNTIME DESTINATION bin COMPONENT program)
install(TARGETS tactile-all tactile_torch tactile_opencv
  RUNTIME DESTINATION libexec/tactile COMPONENT program
  LIBRARY DESTINATION libexec/tactile COMPONENT program)
install(DIRECTORY configs DESTINATION share/tactile COMPONENT program)
install(PROGRAMS scripts/dv-bridge scripts/ros-bridge DESTINATION share/tactile/scripts COMPONENT program)
install(FILES README.md CHANGELOG.md CONTRIBUTING.md LICENSE DESTINATION share/doc/tactile COMPONENT program)
install(FILES LICENSE DESTINATION share/doc/tactile RENAME copyright COMPONENT program)
install(FILES LICENSE DESTINATION share/doc/tactile-dev RENAME copyright COMPONENT development)
install(DIRECTORY docs DESTINATION share/doc/tactile COMPONENT program)
install(CODE [[  # the pages link to settings
  set(pages "$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/share/doc/tactile")
  file(MAKE_DIRECTORY "${pages}")
  file(CREATE_LINK ../../tactile/configs "${pages}/configs" SYMBOLIC)
]] COMPONENT program)

# The built program writes its man pages and completions, from the declarations that its help shows.
install(CODE "set(TACTILE_PROGRAM \"$<TARGET_FILE:tactile-all>\")" COMPONENT program)
install(SCRIPT cmake/install_pages.cmake COMPONENT program)

# The libraries, and the stages that they stand on.
set(libraries core events heatmaps model_inference)
set(waiting ${libraries})
while(waiting)
  list(POP_FRONT waiting library)
  get_target_property(links tactile_${library} LINK_LIBRARIES)
  foreach(link IN LISTS links)
    if(link MATCHES "^tactile::(.*)$" AND NOT CMAKE_MATCH_1 IN_LIST libraries)
      list(APPEND libraries ${CMAKE_MATCH_1})
      list(APPEND waiting ${CMAKE_MATCH_1})
    endif()
  endforeach()
endwhile()
foreach(library IN LISTS libraries)
  set_target_properties(tactile_${library} PROPERTIES EXPORT_NAME ${library})
  install(TARGETS tactile_${library} EXPORT tactile
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
    FILE_SET HEADERS DESTINATION include COMPONENT development)
endforeach()
set(package ${CMAKE_INSTALL_LIBDIR}/cmake/tactile)
install(EXPORT tactile FILE tactileTargets.cmake NAMESPACE tactile:: DESTINATION ${package} COMPONENT development)
configure_package_config_file(cmake/tactileConfig.cmake.in ${PROJECT_BINARY_DIR}/tactileConfig.cmake INSTALL_DESTINATION ${package})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/tactileConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/tactileConfig.cmake ${PROJECT_BINARY_DIR}/tactileConfigVersion.cmake cmake/library_dependencies.cmake
  DESTINATION ${package} COMPONENT development)
install(DIRECTORY examples/predict DESTINATION share/doc/tactile-dev/examples COMPONENT development)
