# SPDX-License-Identifier: MIT
# Raspberry Pi and its like with 64 bits, Debian's arm64.
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(DREHGEBER_TRIPLET aarch64-linux-gnu)
set(DREHGEBER_ARCHITECTURE arm64)
set(DREHGEBER_QEMU qemu-aarch64)
include(${CMAKE_CURRENT_LIST_DIR}/linux-cross.cmake)
