# The solver's tests. A part's test calls its kernels or judges its rules in a step or a few; its motion test runs the
# simulation for longer. The CPU's binaries are physics_unit_test (seconds), physics_test and stability_test (minutes);
# the same cases, but those that call kernels on the host, make the GPU's, whose tests skip themselves where there is no
# GPU.
set(physics_support_sources ../support/equations.cpp ../support/kernels.cpp ../support/validation.cpp)
set(physics_host_sources
  physics/cell_grid_test.cpp physics/contact_stress_test.cpp physics/distance_test.cpp physics/elastic_test.cpp physics/implicit_elastic_test.cpp
  physics/pieces_test.cpp physics/plastic_test.cpp physics/smoothing_test.cpp physics/tear_test.cpp)
set(physics_unit_sources
  backend/neighbor_lists_test.cpp physics/near_body_test.cpp physics/walls_test.cpp physics/wall_share_test.cpp physics/rigid_contact_test.cpp
  physics/diffusion_test.cpp physics/drops_test.cpp physics/equations_test.cpp physics/heat_test.cpp physics/implicit_elastic_motion_test.cpp physics/outside_test.cpp physics/proxy_contact_test.cpp
  physics/proxy_test.cpp physics/rigid_pieces_test.cpp physics/rigid_test.cpp physics/shift_test.cpp physics/state_change_test.cpp
  physics/viscosity_test.cpp solver/conservation_test.cpp solver/degenerate_bodies_test.cpp solver/health_test.cpp
  solver/elastic_limit_test.cpp solver/expected_speed_test.cpp solver/fluid_interval_test.cpp solver/frame_test.cpp
  solver/left_out_particles_test.cpp solver/lightness_test.cpp
  solver/plan_test.cpp)
set(physics_sources
  ../cases/buoyancy_test.cpp ../cases/crepe_scene_test.cpp ../cases/cuboid_scenes_test.cpp
  ../cases/dam_break_test.cpp ../cases/density_ratio_test.cpp ../cases/elastic_scenes_test.cpp
  ../cases/film_test.cpp ../cases/hydrostatics_test.cpp ../cases/kitchen_scene_test.cpp ../cases/lid_corner_test.cpp
  ../cases/melting_scenes_test.cpp ../cases/rest_test.cpp ../cases/resting_noise_test.cpp
  ../cases/shear_flow_test.cpp ../cases/sleep_test.cpp ../cases/staged_viscosity_flow_test.cpp
  ../cases/stirred_volume_test.cpp ../cases/switches_test.cpp ../cases/thin_walls_test.cpp ../cases/turning_test.cpp physics/cohesion_test.cpp
  physics/rigid_contact_motion_test.cpp physics/rolling_test.cpp physics/elastic_contact_test.cpp physics/elastic_indentation_test.cpp physics/elastic_motion_test.cpp physics/elastic_sections_test.cpp
  physics/frozen_contact_test.cpp physics/heat_flow_test.cpp physics/heat_walls_test.cpp physics/plastic_motion_test.cpp
  physics/rigid_pieces_motion_test.cpp physics/state_change_motion_test.cpp physics/tear_motion_test.cpp)
set(stability_sources ../cases/stability_test.cpp)
# GCC 12 finds its own intrinsics of 512 bits uninitialized in Eigen's products of large matrices (its bug 105593)
set_source_files_properties(solver/elastic_limit_test.cpp PROPERTIES COMPILE_OPTIONS "$<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>")

# what only tools/validate runs: cases that take longer than a test of every day may
set(validation_sources
  ../cases/cantilever_test.cpp ../cases/closed_system_test.cpp ../cases/cradle_test.cpp
  ../cases/dam_break_box_test.cpp ../cases/lattice_ripple_test.cpp ../cases/lid_cavity_test.cpp
  ../cases/waves_test.cpp)

# what .ci/run steps under the sanitizers, where a step takes ten times as long: each module of the solver once
set(physics_sanitized_sources ${physics_unit_sources} ${physics_host_sources})
list(FILTER physics_sanitized_sources INCLUDE REGEX
  "/(conservation|health|outside|pieces|rigid_contact|state_change|rigid_pieces|implicit_elastic_motion|[a-z]*_lists)_test.cpp$")

# compiled once for both back ends; ../support/backend.cpp says which one a binary tests
set(physics_libs palp_bridge palp_probes palp_config)
set(cpu_vs_cuda_sources backend/cpu_vs_cuda_test.cpp)
foreach(cases physics_support physics_host physics_unit physics stability physics_sanitized validation cpu_vs_cuda)
  add_library(${cases}_cases OBJECT EXCLUDE_FROM_ALL ${${cases}_sources})
  target_link_libraries(${cases}_cases PRIVATE palp_options ${physics_libs} GTest::gtest)
  use_precompiled_headers(${cases}_cases test_headers)
  computes(${cases}_cases)
  target_compile_definitions(${cases}_cases PRIVATE PALP_SOURCE_DIR="${CMAKE_SOURCE_DIR}")
endforeach()

# physics_binary(NAME name CASES ... LABELS ... TIMEOUT seconds [CUDA])
function(physics_binary)
  cmake_parse_arguments(P "CUDA" "NAME;TIMEOUT" "CASES;LABELS" ${ARGN})
  set(sources ../support/backend.cpp ../support/poisoned_memory.cpp)
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
physics_binary(NAME stability_test CASES stability LABELS stability TIMEOUT 300)
physics_binary(NAME validation_test CASES validation LABELS validation TIMEOUT 1200)
if(PALP_SANITIZE)
  physics_binary(NAME physics_sanitized_test CASES physics_sanitized LABELS sanitized TIMEOUT 600)
endif()
if(PALP_HAVE_CUDA)
  physics_binary(NAME physics_gpu_test CASES physics_unit physics stability LABELS gpu TIMEOUT 300 CUDA)
  physics_binary(NAME validation_gpu_test CASES validation LABELS validation TIMEOUT 1200 CUDA)
  physics_binary(NAME cpu_vs_cuda_test CASES cpu_vs_cuda LABELS gpu TIMEOUT 300 CUDA)
endif()
