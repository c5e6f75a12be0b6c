# SPDX-License-Identifier: MIT
# What FMUs are made of besides their description, in fmu-parts/ of the build tree: a shared object for each version
# of FMI, the sources, and a list of these.
# usage: cmake -D TREE=... -D TO=... -P fmu-parts.cmake
set(parts ${TO}/sources)
file(REMOVE_RECURSE ${parts})
file(COPY ${TREE}/include/drehgeber DESTINATION ${parts} FILES_MATCHING PATTERN *.h)
file(COPY ${TREE}/src ${TREE}/platform/fmu DESTINATION ${parts} FILES_MATCHING PATTERN *.c PATTERN *.h PATTERN *.def
  PATTERN describe.* EXCLUDE)
file(COPY_FILE ${TREE}/LICENSE ${TO}/terms.txt)
file(GLOB_RECURSE list RELATIVE ${parts} ${parts}/*.[ch] ${parts}/*.def)
list(SORT list)
list(JOIN list "\n" list)
file(WRITE ${TO}/sources.list "${list}\n")
