# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0

# active_handeye_batches(TARGET): compiles several sources as one, since most of what each costs the compiler are the same headers.
# CMAKE_UNITY_BUILD=OFF for one by one, as clang-tidy and daily work want it.
function(active_handeye_batches target)
  if(NOT DEFINED CMAKE_UNITY_BUILD)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 7)
  endif()
endfunction()
