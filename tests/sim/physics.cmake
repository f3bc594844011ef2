# The solver's tests. The CPU's binaries are physics_unit_test (seconds) and physics_test (minutes); the same sources,
# but those that call kernels on the host, make the GPU's, whose tests skip themselves where there is no GPU.
set(physics_support ../support/backend.cpp ../support/equations.cpp ../support/validation.cpp)
set(physics_host_sources
  distance_test.cpp elastic_test.cpp kernels_test.cpp neighbors_test.cpp pieces_test.cpp plastic_test.cpp tear_test.cpp)
set(physics_unit_sources
  conservation_test.cpp contact_test.cpp equations_test.cpp health_test.cpp heat_test.cpp kept_lists_test.cpp plan_test.cpp
  proxy_test.cpp rigid_test.cpp rigidify_test.cpp state_change_test.cpp viscosity_test.cpp)
set(physics_sources
  batter_test.cpp buoyancy_test.cpp change_motion_test.cpp cohesion_test.cpp contact_motion_test.cpp
  crepe_scene_test.cpp cuboid_scenes_test.cpp dam_break_test.cpp density_ratio_test.cpp elastic_contact_test.cpp
  elastic_physics_test.cpp elastic_scenes_test.cpp frozen_contact_test.cpp heat_flow_test.cpp hydrostatics_test.cpp
  kitchen_scene_test.cpp melting_scenes_test.cpp plastic_physics_test.cpp rest_test.cpp resting_noise_test.cpp
  rigidify_motion_test.cpp shear_flow_test.cpp stability_test.cpp
  tear_physics_test.cpp)

palp_test(NAME physics_unit_test SOURCES ${physics_unit_sources} ${physics_host_sources} ${physics_support}
  LIBS palp_simulation palp_scene palp_config LABELS unit)
palp_test(NAME physics_test SOURCES ${physics_sources} ${physics_support}
  LIBS palp_bridge palp_simulation palp_scene palp_config LABELS physics TIMEOUT 300)

# what only tools/validate runs: cases that take longer than a test of every day may
set(validation_sources
  cantilever_test.cpp closed_system_test.cpp cradle_test.cpp dam_break_box_test.cpp lid_cavity_test.cpp)
palp_test(NAME validation_test SOURCES ${validation_sources} ${physics_support}
  LIBS palp_simulation palp_scene palp_config LABELS validation TIMEOUT 1200)

if(PALP_HAVE_CUDA)
  palp_test(NAME physics_gpu_test SOURCES ${physics_unit_sources} ${physics_sources} ${physics_support}
    LIBS palp_bridge palp_simulation palp_scene palp_config LABELS gpu TIMEOUT 300)
  target_compile_definitions(physics_gpu_test PRIVATE PALP_TEST_CUDA)
  palp_test(NAME validation_gpu_test SOURCES ${validation_sources} ${physics_support}
    LIBS palp_simulation palp_scene palp_config LABELS validation TIMEOUT 1200)
  target_compile_definitions(validation_gpu_test PRIVATE PALP_TEST_CUDA)
  palp_test(NAME cpu_vs_cuda_test SOURCES cpu_vs_cuda_test.cpp ${physics_support}
    LIBS palp_simulation palp_config LABELS gpu TIMEOUT 300)
  target_compile_definitions(cpu_vs_cuda_test PRIVATE PALP_TEST_CUDA)
endif()
