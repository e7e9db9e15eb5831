# This file is part of OpenCV project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution and at http://opencv.org/license.html.

# Sets ACTIVE_HANDEYE_EIGEN_DIR to the headers of Eigen 3.4 or newer, or to nothing. Looks at Eigen's own package first (Debian's
# libeigen3-dev, the wheel cmeel-eigen), then for the header alone.
find_package(Eigen3 QUIET CONFIG PATH_SUFFIXES cmeel.prefix/share/eigen3/cmake)
if(TARGET Eigen3::Eigen AND NOT Eigen3_VERSION VERSION_LESS 3.4)
  get_target_property(ACTIVE_HANDEYE_EIGEN_DIR Eigen3::Eigen INTERFACE_INCLUDE_DIRECTORIES)
else()
  find_path(ACTIVE_HANDEYE_EIGEN_DIR Eigen/Core
            HINTS ${EIGEN_INCLUDE_PATH} PATH_SUFFIXES eigen3 include/eigen3 cmeel.prefix/include/eigen3)
  mark_as_advanced(ACTIVE_HANDEYE_EIGEN_DIR)
  if(ACTIVE_HANDEYE_EIGEN_DIR)
    file(STRINGS "${ACTIVE_HANDEYE_EIGEN_DIR}/Eigen/src/Core/util/Macros.h" lines REGEX "define EIGEN_(WORLD|MAJOR)_VERSION")
    string(REGEX REPLACE "[^0-9;]" "" numbers "${lines}")
    string(REPLACE ";" "." version "${numbers}")
    if(version VERSION_LESS 3.4)
      set(ACTIVE_HANDEYE_EIGEN_DIR "")
    endif()
  endif()
endif()
set(ACTIVE_HANDEYE_EIGEN_NEEDED "Eigen 3.4 or newer is needed: set Eigen3_DIR to the folder of Eigen3Config.cmake, or install it (Debian: libeigen3-dev)")
