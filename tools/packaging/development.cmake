# palp-dev: shared libraries as targets palp::simulation, palp::bus and what these rest on, and the headers they are
# called by.
set(libraries palp_config palp_threads palp_geometry palp_scene palp_simulation palp_probes palp_wire palp_bus_cyclone palp_bus_fastdds palp_bus)
set(interfaces palp_options palp_contract palp_config_types)
set(abi ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
set_target_properties(${libraries} PROPERTIES VERSION ${PROJECT_VERSION} SOVERSION ${abi}
  INSTALL_RPATH $ORIGIN LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib)
foreach(target ${libraries} ${interfaces})
  string(REGEX REPLACE "^palp_" "" name ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
endforeach()
install(TARGETS ${libraries} ${interfaces} EXPORT palpTargets
  LIBRARY COMPONENT programs NAMELINK_COMPONENT development)

if(TARGET palp_simulation_v3)
  set(faster glibc-hwcaps/x86-64-v3)
  set_target_properties(palp_simulation_v3 PROPERTIES OUTPUT_NAME palp_simulation VERSION ${PROJECT_VERSION} SOVERSION ${abi}
    INSTALL_RPATH $ORIGIN/../.. LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib/${faster})
  install(TARGETS palp_simulation_v3 LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/${faster} COMPONENT programs NAMELINK_SKIP)
endif()

include(tools/packaging/public_headers.cmake)
foreach(header ${headers})
  get_filename_component(folder ${header} DIRECTORY)
  install(FILES ${header} DESTINATION include/palp/${folder} COMPONENT development)
endforeach()

include(CMakePackageConfigHelpers)
set(cmakedir ${CMAKE_INSTALL_LIBDIR}/cmake/palp)
install(EXPORT palpTargets NAMESPACE palp:: DESTINATION ${cmakedir} COMPONENT development)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/packaging/palpConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES tools/packaging/palpConfig.cmake ${CMAKE_BINARY_DIR}/packaging/palpConfigVersion.cmake
  DESTINATION ${cmakedir} COMPONENT development)
install(FILES idl/palp.idl DESTINATION ${CMAKE_INSTALL_DATADIR}/palp/idl COMPONENT development)
install(DIRECTORY tools/examples/ DESTINATION ${CMAKE_INSTALL_DOCDIR}/examples COMPONENT development
  PATTERN __pycache__ EXCLUDE)
if(TARGET palp_python)
  install(TARGETS palp_python LIBRARY DESTINATION lib/python3/dist-packages COMPONENT python)
  set_target_properties(palp_python PROPERTIES INSTALL_RPATH "$ORIGIN/../../../${CMAKE_INSTALL_LIBDIR}")
endif()
