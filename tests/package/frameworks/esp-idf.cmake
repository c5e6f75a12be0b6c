# SPDX-License-Identifier: MIT
# ESP-IDF's part, as a script like its own first look at a component: prints sources and folders.
# usage: cmake -D ROOT=TREE -P esp-idf.cmake
function(idf_component_register)
  cmake_parse_arguments(PARSE_ARGV 0 component "" "" "SRCS;INCLUDE_DIRS")
  foreach(source IN LISTS component_SRCS)
    message("source ${source}")
  endforeach()
  foreach(folder IN LISTS component_INCLUDE_DIRS)
    message("include ${ROOT}/${folder}")
  endforeach()
endfunction()
set(ESP_PLATFORM 1)
include(${ROOT}/CMakeLists.txt)
