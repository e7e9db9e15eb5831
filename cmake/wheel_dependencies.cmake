# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0

# Where find_package() looks for what a wheel is built with; a relative folder is one of this project. What is missing there is not
# looked for elsewhere: a shared library of the system would make a wheel that runs on this machine only.
get_filename_component(folder "${ACTIVE_HANDEYE_WHEEL_DEPENDENCIES}" ABSOLUTE BASE_DIR "${PROJECT_SOURCE_DIR}")
find_package(OpenCV REQUIRED CONFIG COMPONENTS core PATHS "${folder}" NO_DEFAULT_PATH)
find_package(Eigen3 REQUIRED CONFIG PATHS "${folder}/eigen" PATH_SUFFIXES cmeel.prefix/share/eigen3/cmake NO_DEFAULT_PATH)
