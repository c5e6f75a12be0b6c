# SPDX-License-Identifier: MIT
# The component that ESP-IDF makes of this tree: all of src/, of which an image gets what it names. Also run
# as a script, when ESP-IDF asks what a component needs.
file(GLOB_RECURSE sources ${CMAKE_CURRENT_LIST_DIR}/../../src/*.c)
idf_component_register(SRCS ${sources} INCLUDE_DIRS include)
