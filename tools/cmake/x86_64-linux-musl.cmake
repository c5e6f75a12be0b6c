# SPDX-License-Identifier: MIT
# musl beside glibc, by Debian's musl-tools: the library, and its tests with a cmocka made of its sources
# (tools/sysroot cmocka).
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR x86_64)
set(CMAKE_C_COMPILER musl-gcc)
# What this machine has is glibc's.
set(ENV{PKG_CONFIG_LIBDIR} /usr/lib/x86_64-linux-musl/pkgconfig)
set(CMAKE_FIND_ROOT_PATH /usr/lib/x86_64-linux-musl)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
cmake_path(SET cmocka NORMALIZE ${CMAKE_CURRENT_LIST_DIR}/../../build/sysroot/cmocka)
if(EXISTS ${cmocka}/complete)
  set(DREHGEBER_CMOCKA ${cmocka})
endif()
