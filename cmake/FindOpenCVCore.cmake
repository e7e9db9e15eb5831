# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0

# find_package(OpenCVCore 4.6): the target OpenCVCore::OpenCVCore and OpenCVCore_VERSION, for OpenCV 4 and 5 alike.
# OpenCV's own package accepts one major version only, and some distributions (Debian's libopencv-core-dev) ship the library
# without that package: then header and library are looked up by name.
find_package(OpenCV QUIET CONFIG COMPONENTS core)

if(OpenCV_FOUND)
  set(OpenCVCore_VERSION "${OpenCV_VERSION}")
  set(OpenCVCore_LIBRARY opencv_core)
  set(OpenCVCore_INCLUDE_DIR "${OpenCV_INCLUDE_DIRS}")
else()
  find_path(OpenCVCore_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv5 opencv4)
  find_library(OpenCVCore_LIBRARY opencv_core)
  mark_as_advanced(OpenCVCore_INCLUDE_DIR OpenCVCore_LIBRARY)
  if(OpenCVCore_INCLUDE_DIR)
    file(STRINGS "${OpenCVCore_INCLUDE_DIR}/opencv2/core/version.hpp" lines REGEX "define CV_VERSION_(MAJOR|MINOR|REVISION)")
    string(REGEX REPLACE "[^0-9;]" "" numbers "${lines}")
    string(REPLACE ";" "." OpenCVCore_VERSION "${numbers}")
  endif()
endif()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenCVCore
  REQUIRED_VARS OpenCVCore_LIBRARY OpenCVCore_INCLUDE_DIR
  VERSION_VAR OpenCVCore_VERSION
  REASON_FAILURE_MESSAGE "set OpenCV_DIR to the folder of OpenCVConfig.cmake, or install OpenCV's core (Debian: libopencv-core-dev)")

if(OpenCVCore_FOUND AND NOT TARGET OpenCVCore::OpenCVCore)
  add_library(OpenCVCore::OpenCVCore INTERFACE IMPORTED)
  set_target_properties(OpenCVCore::OpenCVCore PROPERTIES
    INTERFACE_INCLUDE_DIRECTORIES "${OpenCVCore_INCLUDE_DIR}"
    INTERFACE_LINK_LIBRARIES "${OpenCVCore_LIBRARY}")
endif()
