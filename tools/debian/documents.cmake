# SPDX-License-Identifier: Apache-2.0
# CPack runs this before it packs the installed files. In a Debian package, documents have the names and forms of Debian:
# `copyright` refers to the licence, which every system has, and a changelog is compressed.
if(NOT CPACK_GENERATOR STREQUAL DEB)
  return()
endif()
set(documents ${CPACK_TEMPORARY_INSTALL_DIRECTORY}/usr/share/doc/gnosphere)
file(REMOVE ${documents}/LICENSE)
file(COPY ${CMAKE_CURRENT_LIST_DIR}/copyright ${CMAKE_CURRENT_LIST_DIR}/../../CHANGELOG.md DESTINATION ${documents}
  FILE_PERMISSIONS OWNER_READ OWNER_WRITE GROUP_READ WORLD_READ)
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)  # of SOURCE_DATE_EPOCH, if it is set
file(WRITE ${documents}/changelog "\
${CPACK_PACKAGE_NAME} (${CPACK_PACKAGE_VERSION}) unstable; urgency=medium

  * What is new in this version stands in CHANGELOG.md.gz, beside this file.

 -- ${CPACK_PACKAGE_CONTACT}  ${date}
")
execute_process(COMMAND gzip -9n changelog CHANGELOG.md WORKING_DIRECTORY ${documents} COMMAND_ERROR_IS_FATAL ANY)
