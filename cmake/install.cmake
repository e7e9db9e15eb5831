# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0

# `cmake --install`: the library for C++ users, found again with find_package(active_handeye).
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/active_handeye")
set(config "${PROJECT_BINARY_DIR}/active_handeyeConfig.cmake")

install(TARGETS active_handeye EXPORT active_handeyeTargets COMPONENT cpp)
install(DIRECTORY "${PROJECT_SOURCE_DIR}/modules/active_handeye/include/" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}" COMPONENT cpp)
install(EXPORT active_handeyeTargets NAMESPACE active_handeye:: DESTINATION "${package_dir}" COMPONENT cpp)

file(WRITE "${config}" [[
include(CMakeFindDependencyMacro)
list(APPEND CMAKE_MODULE_PATH "${CMAKE_CURRENT_LIST_DIR}")
find_dependency(OpenCVCore)
include("${CMAKE_CURRENT_LIST_DIR}/active_handeyeTargets.cmake")
]])
write_basic_package_version_file("${config}.version" COMPATIBILITY SameMinorVersion)
install(FILES "${config}.version" DESTINATION "${package_dir}" RENAME active_handeyeConfigVersion.cmake COMPONENT cpp)
install(FILES "${config}" "${PROJECT_SOURCE_DIR}/cmake/FindOpenCVCore.cmake" DESTINATION "${package_dir}" COMPONENT cpp)
