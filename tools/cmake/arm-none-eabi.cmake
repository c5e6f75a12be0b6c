# SPDX-License-Identifier: MIT
# Arm Cortex-M; DREHGEBER_CPU says which (default: cortex-m4).
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR arm)
set(DREHGEBER_CPU cortex-m4 CACHE STRING "The -mcpu of the Cortex-M")
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES DREHGEBER_CPU)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
set(CMAKE_C_COMPILER arm-none-eabi-gcc)
set(CMAKE_C_FLAGS_INIT "-mcpu=${DREHGEBER_CPU} -mthumb -ffreestanding -ffunction-sections -fdata-sections")
set(DREHGEBER_BINUTILS arm-none-eabi-)
set(DREHGEBER_LIBC --specs=nano.specs) # when linked; newlib without what a controller has no room for
