# SPDX-License-Identifier: MIT
# The most significant byte comes first: whoever takes the order of bytes for granted is found here.
set(CMAKE_SYSTEM_PROCESSOR s390x)
set(DREHGEBER_TRIPLET s390x-linux-gnu)
set(DREHGEBER_ARCHITECTURE s390x)
set(DREHGEBER_QEMU qemu-s390x)
include(${CMAKE_CURRENT_LIST_DIR}/linux-cross.cmake)
