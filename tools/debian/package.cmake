# SPDX-License-Identifier: Apache-2.0
# What CPack needs for a Debian package (cpack -G DEB). lintian, Debian's checker of packages, finds no error in it.
set(CPACK_PACKAGE_VENDOR "The GnoSphere authors")
set(CPACK_PACKAGE_CONTACT "The GnoSphere authors <gnosphere@users.noreply.github.com>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "LiDAR simulator that never casts a ray")
set(CPACK_PACKAGE_DESCRIPTION "\
GnoSphere computes what a LiDAR sensor measures in a scene of triangles.
It projects the scene onto the directions of the sensor's beams with
Vulkan, on graphics cards and on CPUs, and adds noise, weather, materials
and motion.
.
The package has the command gnosphere, the library for C and C++ with its
headers, and a library with the interface of RobotecGPULidar.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/documents.cmake)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)           # adds the shared libraries that ours link to
set(CPACK_DEBIAN_PACKAGE_DEPENDS libvulkan1)     # opened at run time, so CPack does not find it
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS mesa-vulkan-drivers)
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "g++, pkg-config, libjs-three")
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA ${CMAKE_CURRENT_LIST_DIR}/triggers)  # ldconfig runs after an installation
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
include(CPack)
