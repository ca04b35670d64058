# SPDX-License-Identifier: Apache-2.0
# Installs the build into an empty prefix, then builds and runs main.cpp against it in both ways people do.
# Arguments: BUILD (the build folder), WORK (a folder of our own), LIBDIR, CXX.
cmake_minimum_required(VERSION 3.25)
set(prefix ${WORK}/prefix)
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})

function(run)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${WORK} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

function(check_consumer program)
  file(REMOVE ${WORK}/cloud.pcd)
  run(${CMAKE_COMMAND} -E env LD_LIBRARY_PATH=${prefix}/${LIBDIR} ${program} town.glb)
  if(NOT EXISTS ${WORK}/cloud.pcd)
    message(FATAL_ERROR "${program} wrote no cloud.pcd")
  endif()
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix})
run(${prefix}/bin/gnosphere town --triangles 20000 -o town.glb)

# find_package(gnosphere)
run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK}/build -G Ninja
  -D CMAKE_CXX_COMPILER=${CXX} -D CMAKE_PREFIX_PATH=${prefix})
run(${CMAKE_COMMAND} --build ${WORK}/build)
check_consumer(${WORK}/build/consumer)

# pkg-config gnosphere
find_program(PKG_CONFIG NAMES pkg-config pkgconf REQUIRED)
execute_process(
  COMMAND ${CMAKE_COMMAND} -E env PKG_CONFIG_PATH=${prefix}/${LIBDIR}/pkgconfig ${PKG_CONFIG} --cflags --libs gnosphere
  OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
separate_arguments(flags UNIX_COMMAND "${flags}")
run(${CXX} -std=c++20 -Wall -Wextra ${CMAKE_CURRENT_LIST_DIR}/main.cpp ${flags} -o ${WORK}/consumer)
check_consumer(${WORK}/consumer)
