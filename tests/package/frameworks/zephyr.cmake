# SPDX-License-Identifier: MIT
# Zephyr's part, with the option set: prints sources and folders.
# usage: cmake -D ROOT=TREE -P zephyr.cmake
function(zephyr_library_named name)
endfunction()
function(zephyr_library_sources)
  foreach(source IN LISTS ARGN)
    message("source ${source}")
  endforeach()
endfunction()
function(zephyr_include_directories)
  foreach(folder IN LISTS ARGN)
    message("include ${folder}")
  endforeach()
endfunction()
set(CONFIG_DREHGEBER y)
include(${ROOT}/zephyr/CMakeLists.txt)
