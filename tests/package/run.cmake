# SPDX-License-Identifier: Apache-2.0
# Installs the library into an empty prefix, then builds and runs main.cpp with find_package and with pkg-config.
# Arguments: BUILD (a build folder to install), or SOURCE (the repository: another project builds and installs a static
# library from it) and PROGRAM (the command line); WORK (a temporary folder), LIBDIR, CXX, LAUNCHER.
cmake_minimum_required(VERSION 3.25)
set(prefix ${WORK}/prefix)
file(REMOVE_RECURSE ${prefix} ${WORK}/build)
file(MAKE_DIRECTORY ${WORK})
set(compilers -G Ninja -D CMAKE_CXX_COMPILER=${CXX} -D CMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER})

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

if(SOURCE)
  # Without optimisation, because it builds fastest, and only the packaging is tested.
  set(BUILD ${WORK}/holder/build)
  file(WRITE ${WORK}/holder/CMakeLists.txt
    "cmake_minimum_required(VERSION 3.25)\nproject(holder LANGUAGES C CXX)\nadd_subdirectory(${SOURCE} gnosphere)\n")
  run(${CMAKE_COMMAND} -S ${WORK}/holder -B ${BUILD} ${compilers} -D BUILD_SHARED_LIBS=OFF
    -D CMAKE_INSTALL_LIBDIR=${LIBDIR})
  run(${CMAKE_COMMAND} --build ${BUILD})
  set(static --static)
else()
  set(PROGRAM ${prefix}/bin/gnosphere)
endif()
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix})
run(${PROGRAM} town --triangles 20000 -o town.glb)

# find_package(gnosphere)
run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK}/build ${compilers} -D CMAKE_PREFIX_PATH=${prefix})
run(${CMAKE_COMMAND} --build ${WORK}/build)
check_consumer(${WORK}/build/consumer)

# pkg-config gnosphere
find_program(PKG_CONFIG NAMES pkg-config pkgconf REQUIRED)
execute_process(
  COMMAND ${CMAKE_COMMAND} -E env PKG_CONFIG_PATH=${prefix}/${LIBDIR}/pkgconfig
    ${PKG_CONFIG} --cflags --libs ${static} gnosphere
  OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
separate_arguments(flags UNIX_COMMAND "${flags}")
run(${CXX} -std=c++20 -Wall -Wextra ${CMAKE_CURRENT_LIST_DIR}/main.cpp ${flags} -o ${WORK}/consumer)
check_consumer(${WORK}/consumer)
