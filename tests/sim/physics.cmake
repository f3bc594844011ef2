# The solver's tests. physics_unit_test and physics_test run on the CPU; the same sources but those that call kernels
# on the host make the GPU's binaries, which skip themselves where there is no GPU.
set(physics_support ../support/backend.cpp ../support/equations.cpp)
set(physics_unit_sources
  conservation_test.cpp equations_test.cpp health_test.cpp plan_test.cpp proxy_test.cpp rigid_test.cpp)
set(physics_host_sources kernels_test.cpp neighbors_test.cpp)
palp_test(NAME physics_unit_test SOURCES ${physics_unit_sources} ${physics_host_sources} ${physics_support}
  LIBS palp_simulation palp_config LABELS unit)
