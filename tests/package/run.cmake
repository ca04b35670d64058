# SPDX-License-Identifier: Apache-2.0
# Installs the library into an empty prefix, then builds and runs a program with find_package and with pkg-config.
# Arguments: PROGRAM (the command line), WORK (a folder of our own), LIBDIR, CXX, LAUNCHER, and one of these
#   BUILD   a build folder to install; its library is a shared one if SHARED is on, a static one if not
#   SOURCE  the repository: another project adds it, which builds a static library, and installs that; with CORE on, one
#           without GNOSPHERE_IO, and the program is core.cpp
cmake_minimum_required(VERSION 3.25)
set(prefix ${WORK}/prefix)
file(REMOVE_RECURSE ${prefix} ${WORK}/build)
file(MAKE_DIRECTORY ${WORK})
set(compilers -G Ninja -D CMAKE_CXX_COMPILER=${CXX} -D CMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER})
set(consumer main.cpp)
set(static --static)

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

run(${PROGRAM} town --triangles 20000 -o town.glb)

if(SOURCE)
  # This build has no optimisation and one file per folder, because only the packaging is tested and such a build is
  # fastest.
  set(BUILD ${WORK}/holder/build)
  set(options -D CMAKE_UNITY_BUILD=ON -D CMAKE_INSTALL_LIBDIR=${LIBDIR})
  if(CORE)
    # Headers that the library alone must not need are replaced by files that fail to compile.
    set(consumer core.cpp)
    set(absent ${WORK}/absent)
    foreach(header IN ITEMS tiny_gltf.h tiny_obj_loader.h stb_image.h stb_image_write.h stb_easy_font.h
        draco/compression/decode.h CLI/CLI.hpp catch2/catch_test_macros.hpp pugixml.hpp yaml-cpp/yaml.h)
      file(WRITE ${absent}/${header} "#error \"the library alone needs ${header}\"\n")
    endforeach()
    list(APPEND options -D GNOSPHERE_IO=OFF -D CMAKE_CXX_FLAGS=-I${absent}
      -D CMAKE_DISABLE_FIND_PACKAGE_CLI11=ON -D CMAKE_DISABLE_FIND_PACKAGE_Catch2=ON
      -D CMAKE_DISABLE_FIND_PACKAGE_pugixml=ON)
  endif()
  file(WRITE ${WORK}/holder/CMakeLists.txt
    "cmake_minimum_required(VERSION 3.25)\nproject(holder LANGUAGES C CXX)\nadd_subdirectory(${SOURCE} gnosphere)\n")
  run(${CMAKE_COMMAND} -S ${WORK}/holder -B ${BUILD} ${compilers} ${options})
  run(${CMAKE_COMMAND} --build ${BUILD})
elseif(SHARED)
  set(static)
endif()
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix})

# An installation can be moved, so its files must not contain the path of the build or of a library.
file(GLOB descriptions ${prefix}/${LIBDIR}/cmake/gnosphere/*.cmake ${prefix}/${LIBDIR}/pkgconfig/*.pc)
foreach(description IN LISTS descriptions)
  file(STRINGS ${description} lines REGEX "/usr/(lib|include)/|${WORK}/")
  if(lines)
    message(FATAL_ERROR "${description} names a path: ${lines}")
  endif()
endforeach()
if(NOT descriptions)
  message(FATAL_ERROR "nothing in ${prefix}/${LIBDIR} describes the library")
endif()

# The licences, and the documents that headers refer to, are in the folder of this project, whoever installs it.
foreach(document IN ITEMS LICENSE THIRD_PARTY.md README.md docs/api.md docs/engine.md)
  if(NOT EXISTS ${prefix}/share/doc/gnosphere/${document})
    message(FATAL_ERROR "${prefix}/share/doc/gnosphere has no ${document}")
  endif()
endforeach()

# If the program is installed, it runs from the prefix.
if(EXISTS ${prefix}/bin/gnosphere)
  run(${prefix}/bin/gnosphere scan town.glb --pose 0,0,1.8 -o cloud.pcd)
endif()

# Test with find_package(gnosphere).
run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK}/build ${compilers} -D CMAKE_BUILD_TYPE=Release
  -D CMAKE_PREFIX_PATH=${prefix} -D CONSUMER=${consumer})
run(${CMAKE_COMMAND} --build ${WORK}/build)
check_consumer(${WORK}/build/consumer)

# Test with pkg-config gnosphere.
find_program(PKG_CONFIG NAMES pkg-config pkgconf REQUIRED)
execute_process(
  COMMAND ${CMAKE_COMMAND} -E env PKG_CONFIG_PATH=${prefix}/${LIBDIR}/pkgconfig
    ${PKG_CONFIG} --cflags --libs ${static} gnosphere
  OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
separate_arguments(flags UNIX_COMMAND "${flags}")
run(${CXX} -std=c++20 -O2 -Wall -Wextra ${CMAKE_CURRENT_LIST_DIR}/${consumer} ${flags} -o ${WORK}/consumer)
check_consumer(${WORK}/consumer)

# Test RGL's interface, in C++ and in C, by the name that its programs link.
find_program(CC NAMES cc gcc clang REQUIRED)
set(rgl ${prefix}/${LIBDIR}/gnosphere/rgl)
if(EXISTS ${rgl})
  run(${CXX} -std=c++17 -I${prefix}/include/gnosphere/compat ${CMAKE_CURRENT_LIST_DIR}/rgl.cpp -L${rgl} -lRobotecGPULidar
    -o ${WORK}/rgl_consumer)
  run(${CMAKE_COMMAND} -E env LD_LIBRARY_PATH=${rgl} GNOSPHERE_RGL_DEVICE=reference ${WORK}/rgl_consumer)
  run(${CC} -std=c11 -Wall -Wextra -Werror -I${prefix}/include/gnosphere/compat ${CMAKE_CURRENT_LIST_DIR}/rgl.c -L${rgl}
    -lRobotecGPULidar -o ${WORK}/rgl_c_consumer)
  run(${CMAKE_COMMAND} -E env LD_LIBRARY_PATH=${rgl} ${WORK}/rgl_c_consumer)
endif()

# Test the C interface from C, and the symbols that a shared library exports.
if(SHARED AND NOT SOURCE)
  run(${CC} -std=c99 -O2 -Wall -Wextra ${CMAKE_CURRENT_LIST_DIR}/../../examples/c/scan.c ${flags} -lm -o ${WORK}/c_consumer)
  run(${CMAKE_COMMAND} -E env LD_LIBRARY_PATH=${prefix}/${LIBDIR} ${WORK}/c_consumer town.glb c.pcd)
  run(${CC} -std=c99 -O2 -Wall -Wextra ${CMAKE_CURRENT_LIST_DIR}/../../examples/c/record.c ${flags} -lvulkan
    -o ${WORK}/c_recorder)
  run(${CMAKE_COMMAND} -E env LD_LIBRARY_PATH=${prefix}/${LIBDIR} ${WORK}/c_recorder town.glb rows.bin)
  run(${CMAKE_CURRENT_LIST_DIR}/symbols ${prefix}/${LIBDIR}/libgnosphere.so)
endif()
