# The solver's tests. The CPU's binaries are physics_unit_test (seconds) and physics_test (minutes); the same cases, but
# those that call kernels on the host, make the GPU's, whose tests skip themselves where there is no GPU.
set(physics_support_sources ../support/equations.cpp ../support/validation.cpp)
set(physics_host_sources
  distance_test.cpp elastic_test.cpp implicit_elastic_test.cpp kernels_test.cpp neighbors_test.cpp pieces_test.cpp plastic_test.cpp tear_test.cpp)
set(physics_unit_sources
  conservation_test.cpp contact_test.cpp equations_test.cpp health_test.cpp heat_test.cpp implicit_physics_test.cpp kept_lists_test.cpp
  odd_bodies_test.cpp outside_test.cpp plan_test.cpp
  proxy_contact_test.cpp proxy_test.cpp rigid_test.cpp rigidify_test.cpp state_change_test.cpp viscosity_test.cpp)
set(physics_sources
  batter_test.cpp buoyancy_test.cpp change_motion_test.cpp cohesion_test.cpp contact_motion_test.cpp
  crepe_scene_test.cpp cuboid_scenes_test.cpp dam_break_test.cpp density_ratio_test.cpp elastic_contact_test.cpp
  elastic_physics_test.cpp elastic_scenes_test.cpp film_test.cpp frozen_contact_test.cpp heat_flow_test.cpp
  hydrostatics_test.cpp
  kitchen_scene_test.cpp melting_scenes_test.cpp plastic_physics_test.cpp rest_test.cpp resting_noise_test.cpp
  rigidify_motion_test.cpp shear_flow_test.cpp stability_test.cpp
  tear_physics_test.cpp)

# what only tools/validate runs: cases that take longer than a test of every day may
set(validation_sources
  cantilever_test.cpp closed_system_test.cpp cradle_test.cpp dam_break_box_test.cpp heave_test.cpp lattice_line_test.cpp
  lid_cavity_test.cpp)

# compiled once for both back ends; ../support/backend.cpp says which one a binary tests
set(physics_libs palp_bridge palp_simulation palp_scene palp_config)
set(cpu_vs_cuda_sources cpu_vs_cuda_test.cpp)
foreach(cases physics_support physics_host physics_unit physics validation cpu_vs_cuda)
  add_library(${cases}_cases OBJECT EXCLUDE_FROM_ALL ${${cases}_sources})
  target_link_libraries(${cases}_cases PRIVATE palp_options ${physics_libs} GTest::gtest)
  target_compile_definitions(${cases}_cases PRIVATE PALP_SOURCE_DIR="${CMAKE_SOURCE_DIR}")
endforeach()

# physics_binary(NAME name CASES ... LABELS ... TIMEOUT seconds [CUDA])
function(physics_binary)
  cmake_parse_arguments(P "CUDA" "NAME;TIMEOUT" "CASES;LABELS" ${ARGN})
  set(sources ../support/backend.cpp)
  foreach(cases physics_support ${P_CASES})
    list(APPEND sources $<TARGET_OBJECTS:${cases}_cases>)
  endforeach()
  palp_test(NAME ${P_NAME} SOURCES ${sources} LIBS ${physics_libs} LABELS ${P_LABELS} TIMEOUT ${P_TIMEOUT})
  if(P_CUDA)
    target_compile_definitions(${P_NAME} PRIVATE PALP_TEST_CUDA)
  endif()
endfunction()

physics_binary(NAME physics_unit_test CASES physics_unit physics_host LABELS unit TIMEOUT 300)
physics_binary(NAME physics_test CASES physics LABELS physics TIMEOUT 300)
physics_binary(NAME validation_test CASES validation LABELS validation TIMEOUT 1200)
if(PALP_HAVE_CUDA)
  physics_binary(NAME physics_gpu_test CASES physics_unit physics LABELS gpu TIMEOUT 300 CUDA)
  physics_binary(NAME validation_gpu_test CASES validation LABELS validation TIMEOUT 1200 CUDA)
  physics_binary(NAME cpu_vs_cuda_test CASES cpu_vs_cuda LABELS gpu TIMEOUT 300 CUDA)
endif()
