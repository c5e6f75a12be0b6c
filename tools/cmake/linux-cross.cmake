# SPDX-License-Identifier: MIT
# Linux on another processor, with Debian's cross compiler for DREHGEBER_TRIPLET. Libraries are those that
# tools/sysroot has fetched for DREHGEBER_ARCHITECTURE; without them, those of this machine
# (dpkg --add-architecture). What was built runs under DREHGEBER_QEMU.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_C_COMPILER ${DREHGEBER_TRIPLET}-gcc)
set(CMAKE_CXX_COMPILER ${DREHGEBER_TRIPLET}-g++)
set(DREHGEBER_BINUTILS ${DREHGEBER_TRIPLET}-)
cmake_path(SET sysroot NORMALIZE ${CMAKE_CURRENT_LIST_DIR}/../../build/sysroot/${DREHGEBER_ARCHITECTURE})
set(root)
if(EXISTS ${sysroot}/complete)
  set(root ${sysroot})
  set(CMAKE_SYSROOT ${sysroot})
endif()
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
# pkg-config knows nothing of targets. Debian's name of the folder is the triplet, but on i386.
string(REPLACE "i686" "i386" folder ${DREHGEBER_TRIPLET})
set(CMAKE_LIBRARY_ARCHITECTURE ${folder})
set(ENV{PKG_CONFIG_LIBDIR} ${root}/usr/lib/${folder}/pkgconfig:${root}/usr/share/pkgconfig)
set(ENV{PKG_CONFIG_SYSROOT_DIR} ${root})
find_program(DREHGEBER_EMULATOR ${DREHGEBER_QEMU})
if(DREHGEBER_EMULATOR)
  set(CMAKE_CROSSCOMPILING_EMULATOR ${DREHGEBER_EMULATOR} -L ${root}/)
endif()
