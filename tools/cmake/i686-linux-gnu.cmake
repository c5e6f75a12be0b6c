# SPDX-License-Identifier: MIT
# A PC with 32 bits, Debian's i386.
set(CMAKE_SYSTEM_PROCESSOR i686)
set(DREHGEBER_TRIPLET i686-linux-gnu)
set(DREHGEBER_ARCHITECTURE i386)
set(DREHGEBER_QEMU qemu-i386)
include(${CMAKE_CURRENT_LIST_DIR}/linux-cross.cmake)
