# SPDX-License-Identifier: MIT
# A PC with 32 bits, Debian's i386.
set(CMAKE_SYSTEM_PROCESSOR i686)
set(DREHGEBER_TRIPLET i686-linux-gnu)
set(DREHGEBER_ARCHITECTURE i386)
set(DREHGEBER_QEMU qemu-i386)
include(${CMAKE_CURRENT_LIST_DIR}/linux-cross.cmake)
# A PC with 64 bits may run it as it is: what that needs is the loader and the libraries of 32 bits.
execute_process(COMMAND ${root}/lib/ld-linux.so.2 --version RESULT_VARIABLE foreign OUTPUT_QUIET ERROR_QUIET)
if(root AND foreign EQUAL 0)
  set(CMAKE_CROSSCOMPILING_EMULATOR ${root}/lib/ld-linux.so.2 --library-path ${root}/lib/${folder})
endif()
