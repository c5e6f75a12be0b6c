# SPDX-License-Identifier: MIT
# What a distribution's own builds have, as far as compiler and linker know it: position independent programs,
# guarded stacks, CET, relocations that are read-only and bound at the start, checked calls of the C library.
include(CheckCCompilerFlag)
include(CheckCSourceCompiles)
include(CheckLinkerFlag)
include(CheckPIESupported)
check_pie_supported(LANGUAGES C)
foreach(flag -fstack-protector-strong -fstack-clash-protection -fcf-protection=full)
  string(MAKE_C_IDENTIFIER "has${flag}" has)
  check_c_compiler_flag(${flag} ${has})
  if(${has})
    add_compile_options(${flag})
  endif()
endforeach()
foreach(flag -Wl,-z,relro -Wl,-z,now)
  string(MAKE_C_IDENTIFIER "has${flag}" has)
  check_linker_flag(C ${flag} ${has})
  if(${has})
    add_link_options(${flag})
  endif()
endforeach()
# glibc 2.36 takes 3, gcc 12 makes use of it. They need an optimizer, and take calls away from the address sanitizer;
# flags may be others the next time, so this is asked each time.
unset(has_fortify CACHE)
set(CMAKE_TRY_COMPILE_CONFIGURATION ${CMAKE_BUILD_TYPE})
check_c_source_compiles("
#ifdef __has_feature
#if __has_feature(address_sanitizer)
#define __SANITIZE_ADDRESS__
#endif
#endif
#if !defined __OPTIMIZE__ || defined __SANITIZE_ADDRESS__
#error
#endif
int main(void) { return 0; }" has_fortify)
unset(CMAKE_TRY_COMPILE_CONFIGURATION)
if(has_fortify)
  add_compile_options(-U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=3)
endif()
