# SPDX-License-Identifier: MIT
# What platform/linux and the command need: targets PkgConfig::NAME and Threads::Threads, and in `missing`,
# in words, what of it the target does not have.
include(CheckIncludeFile)
find_package(Threads)
find_package(PkgConfig QUIET)
set(package_suffix)
if(DREHGEBER_ARCHITECTURE)
  set(package_suffix ":${DREHGEBER_ARCHITECTURE}")
endif()
foreach(row "SYSTEMD libsystemd libsystemd-dev" "MODBUS libmodbus libmodbus-dev" "GPIOD libgpiod libgpiod-dev"
    "NCURSES ncursesw libncurses-dev")
  string(REPLACE " " ";" row "${row}")
  list(POP_FRONT row name module package)
  if(PKG_CONFIG_FOUND)
    pkg_check_modules(${name} QUIET IMPORTED_TARGET ${module})
  endif()
  if(NOT ${name}_FOUND)
    list(APPEND missing "${module} (Debian: ${package}${package_suffix})")
  endif()
endforeach()
# For the panel only: see DREHGEBER_PANEL.
if(PKG_CONFIG_FOUND)
  pkg_check_modules(WEBSOCKETS QUIET IMPORTED_TARGET libwebsockets)
endif()
# glibc has it; musl has not, and a module that pkg-config finds beside musl is another C library's.
check_include_file(argp.h has_argp)
if(NOT has_argp)
  list(APPEND missing "argp.h (glibc)")
endif()
if(NOT PKG_CONFIG_FOUND)
  list(APPEND missing "pkg-config, without which none of them is found (Debian: pkg-config)")
endif()
list(JOIN missing ", " missing)
