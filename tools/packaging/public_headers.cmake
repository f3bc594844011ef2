# The headers that people include, and all that these include, as `headers`. As a script (cmake -P, from the repository's
# root) prints them.
cmake_minimum_required(VERSION 3.25)
set(todo config/data_dir.h config/error.h config/scene_config.h config/version.h idl/bus.h idl/clock.h idl/coupling.h
  idl/frame_assembler.h idl/latest.h idl/particle_sender.h idl/topics.h idl/validate.h sim_server/probes/probes.h
  sim_server/scene/scene.h sim_server/scene/scene_files.h sim_server/solver/simulation.h)
set(headers "")
while(todo)
  list(POP_FRONT todo header)
  if(header IN_LIST headers OR NOT EXISTS ${CMAKE_CURRENT_LIST_DIR}/../../${header})
    continue()
  endif()
  list(APPEND headers ${header})
  file(STRINGS ${CMAKE_CURRENT_LIST_DIR}/../../${header} lines REGEX "^#include \"")
  list(TRANSFORM lines REPLACE "^#include \"([^\"]+)\".*" "\\1")
  list(APPEND todo ${lines})
endwhile()
if(CMAKE_SCRIPT_MODE_FILE)
  list(JOIN headers " " text)
  message(NOTICE "${text}")
endif()
