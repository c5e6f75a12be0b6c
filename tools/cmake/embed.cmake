# SPDX-License-Identifier: MIT
# Files as a table in C, struct web_file of tools/drehgeber/web/files.h.
# usage: cmake -D FROM=FOLDER -D TO=FILE.c "-DFILES=PATH=FILE PATH=FILE ..." -P embed.cmake
set(type_html "text/html; charset=utf-8")
set(type_css "text/css; charset=utf-8")
set(type_js "text/javascript; charset=utf-8")
string(REPLACE " " ";" FILES "${FILES}")
foreach(row IN LISTS FILES)
  string(REGEX MATCH "^([^=]*)=(.*)\\.(.*)$" row "${row}")
  set(path ${CMAKE_MATCH_1})
  set(kind ${CMAKE_MATCH_3})
  file(READ ${FROM}/${CMAKE_MATCH_2}.${kind} text HEX)
  string(REGEX REPLACE "(..)" "0x\\1," text "${text}")
  string(MAKE_C_IDENTIFIER "file_${path}" symbol)
  string(APPEND bytes "static const unsigned char ${symbol}[] = {${text}};\n")
  string(APPEND rows "    {\"/${path}\", \"${type_${kind}}\", ${symbol}, sizeof ${symbol}},\n")
endforeach()
file(WRITE ${TO} "#include \"files.h\"\n\n${bytes}
const struct web_file web_files[] = {\n${rows}};
const size_t web_file_count = sizeof web_files / sizeof web_files[0];\n")
