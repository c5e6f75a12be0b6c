# SPDX-License-Identifier: MIT
# dg_cmocka: cmocka as its package says it, which has told in three ways so far where it is; or, for a C
# library that nobody packages it for, made of its sources.
set(DREHGEBER_CMOCKA "" CACHE PATH "Sources of cmocka, to be built with the tests")
if(DREHGEBER_CMOCKA)
  set(cmocka_FOUND ON)
  add_library(dg_cmocka STATIC EXCLUDE_FROM_ALL ${DREHGEBER_CMOCKA}/src/cmocka.c)
  target_include_directories(dg_cmocka SYSTEM PUBLIC ${DREHGEBER_CMOCKA}/include)
  target_compile_definitions(dg_cmocka PRIVATE HAVE_CLOCK_GETTIME HAVE_STRUCT_TIMESPEC HAVE_SETJMP_H
    HAVE_SIGNAL_H HAVE_STRSIGNAL HAVE_TIME_H HAVE_STDINT_H HAVE_INTTYPES_H HAVE_UNISTD_H HAVE_STRINGS_H _GNU_SOURCE)
  target_compile_options(dg_cmocka PRIVATE -w)
else()
  find_package(cmocka QUIET)
  add_library(dg_cmocka INTERFACE)
  target_include_directories(dg_cmocka SYSTEM INTERFACE ${CMOCKA_INCLUDE_DIR})
  target_link_libraries(dg_cmocka INTERFACE $<IF:$<TARGET_EXISTS:cmocka::cmocka>,cmocka::cmocka,${CMOCKA_LIBRARIES}>)
endif()
