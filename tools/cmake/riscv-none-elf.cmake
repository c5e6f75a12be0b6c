# SPDX-License-Identifier: MIT
# 32-bit RISC-V without floating point; Debian's cross compiler is called riscv64 and does both.
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR riscv32)
set(DREHGEBER_CPU rv32imac)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
set(CMAKE_C_COMPILER riscv64-unknown-elf-gcc)
set(CMAKE_C_FLAGS_INIT "-march=${DREHGEBER_CPU} -mabi=ilp32 --specs=picolibc.specs -ffreestanding -ffunction-sections -fdata-sections")
set(DREHGEBER_BINUTILS riscv64-unknown-elf-)
