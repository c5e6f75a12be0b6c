# SPDX-License-Identifier: MIT
# What is installed and not built: texts for whoever uses the command.
install(FILES LICENSE README.md CHANGELOG.md SECURITY.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
foreach(page "platform/linux|rig-files" "platform/fmu|fmu" "src/control|scpi" "src/hiperface|hiperface" "src/biss|biss" "src/ssi|ssi"
    "src/canopen|canopen" "src/cia406|cia406" "src/interbus|interbus"
    "tools/sigrok|sigrok")
  string(REGEX REPLACE "\\|.*" "" folder ${page})
  string(REGEX REPLACE ".*\\|" "" name ${page})
  install(FILES ${folder}/README.md DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME ${name}.md)
endforeach()
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR}) # what README.md leads to
install(DIRECTORY tools/examples DESTINATION ${CMAKE_INSTALL_DOCDIR} PATTERN __pycache__ EXCLUDE)
install(DIRECTORY tools/eds tools/gtkwave tools/models tools/sigrok DESTINATION ${CMAKE_INSTALL_DATADIR}/drehgeber
  PATTERN __pycache__ EXCLUDE PATTERN README.md EXCLUDE)
foreach(suite hiperface biss ssi canopen cia406 interbus) # what `drehgeber verify` asks
  install(FILES tests/conformance/${suite}.clauses tests/conformance/${suite}.rows
    DESTINATION ${CMAKE_INSTALL_DATADIR}/drehgeber/clauses)
endforeach()
install(DIRECTORY tools/man/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES tools/completion/drehgeber.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
  RENAME drehgeber)
install(FILES tools/completion/_drehgeber DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions)
