# find_package(palp): targets palp::simulation, palp::probes, palp::bus.
include(CMakeFindDependencyMacro)
find_dependency(Eigen3 3.4)
find_dependency(nlohmann_json 3.11)
include(${CMAKE_CURRENT_LIST_DIR}/palpTargets.cmake)
