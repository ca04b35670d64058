# SPDX-License-Identifier: Apache-2.0
# Configures the project in ways that other projects and packagers do, and reads what comes of it. It builds nothing.
# Arguments: SOURCE (the repository), WORK (a folder of our own), CXX (the compiler)
cmake_minimum_required(VERSION 3.25)
file(REMOVE_RECURSE ${WORK})
set(alone -D GNOSPHERE_TOOLS=OFF -D GNOSPHERE_BENCH=OFF -D GNOSPHERE_TESTS=OFF)

# configure(source folder options...): sets `result` and `output`.
function(configure source folder)
  execute_process(COMMAND ${CMAKE_COMMAND} -S ${source} -B ${WORK}/${folder} -G Ninja -D CMAKE_CXX_COMPILER=${CXX} ${ARGN}
    RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  set(result ${result} PARENT_SCOPE)
  set(output "${output}" PARENT_SCOPE)
endfunction()

# Libraries of a project that adds this one are of the kind that it wants, and so is ours. Our documents are not among its.
file(WRITE ${WORK}/holder/after.c "int after;\n")
file(WRITE ${WORK}/holder/CMakeLists.txt "
cmake_minimum_required(VERSION 3.25)
project(holder LANGUAGES C CXX)
include(GNUInstallDirs)
add_subdirectory(${SOURCE} gnosphere)
add_library(after after.c)
foreach(library IN ITEMS gnosphere after)
  get_target_property(type \${library} TYPE)
  if(NOT type STREQUAL KIND)
    message(FATAL_ERROR \"\${library} is a \${type}\")
  endif()
endforeach()
")
configure(${WORK}/holder static -D KIND=STATIC_LIBRARY)
if(result)
  message(FATAL_ERROR "a project that adds this one by add_subdirectory: ${output}")
endif()
file(STRINGS ${WORK}/static/gnosphere/cmake_install.cmake documents REGEX "share/doc/holder|share/doc/gnosphere\"")
if(NOT documents MATCHES "share/doc/gnosphere" OR documents MATCHES "holder")
  message(FATAL_ERROR "documents of GnoSphere in a project that adds it: ${documents}")
endif()
configure(${WORK}/holder shared -D KIND=SHARED_LIBRARY -D BUILD_SHARED_LIBS=ON)
if(result)
  message(FATAL_ERROR "a project of shared libraries that adds this one by add_subdirectory: ${output}")
endif()

# pkg-config tells folders that are given as absolute ones, as they are, and others from its own place.
find_program(PKG_CONFIG NAMES pkg-config pkgconf REQUIRED)
function(check_flags folder wanted)
  configure(${SOURCE} ${folder} ${alone} -D CMAKE_INSTALL_PREFIX=/opt/here ${ARGN})
  execute_process(COMMAND ${CMAKE_COMMAND} -E env PKG_CONFIG_PATH=${WORK}/${folder} ${PKG_CONFIG} --cflags --libs gnosphere
    OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  string(REPLACE "${WORK}/${folder}/" "here/" flags "${flags}")
  if(NOT flags MATCHES "^${wanted} -lgnosphere$")
    message(FATAL_ERROR "pkg-config says ${flags} with ${ARGN}")
  endif()
endfunction()
check_flags(relative "-Ihere/[./]+/include -Lhere/[./]+/lib64" -D CMAKE_INSTALL_LIBDIR=lib64)
check_flags(libraries "-I/opt/here/include -L/opt/there/lib" -D CMAKE_INSTALL_LIBDIR=/opt/there/lib)
check_flags(headers "-I/opt/there/include -Lhere/[./]+/lib"
  -D CMAKE_INSTALL_LIBDIR=lib -D CMAKE_INSTALL_INCLUDEDIR=/opt/there/include)

# Fuzzers that cannot be built are refused.
configure(${SOURCE} fuzz ${alone} -D GNOSPHERE_FUZZ=ON -D BUILD_SHARED_LIBS=OFF)
if(NOT result OR NOT output MATCHES "GNOSPHERE_FUZZ needs")
  message(FATAL_ERROR "GNOSPHERE_FUZZ without tests is taken: ${output}")
endif()
