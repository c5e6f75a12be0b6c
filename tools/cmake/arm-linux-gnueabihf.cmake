# SPDX-License-Identifier: MIT
# ARM with 32 bits and floating point, Debian's armhf.
set(CMAKE_SYSTEM_PROCESSOR armv7l)
set(DREHGEBER_TRIPLET arm-linux-gnueabihf)
set(DREHGEBER_ARCHITECTURE armhf)
set(DREHGEBER_QEMU qemu-arm)
include(${CMAKE_CURRENT_LIST_DIR}/linux-cross.cmake)
