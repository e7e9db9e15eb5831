# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0

# active_handeye_warnings(TARGET): the warnings that OpenCV's own build turns on, and a few more; only for our sources.
function(active_handeye_warnings target)
  if(MSVC)
    target_compile_options(${target} PRIVATE /W4 $<$<BOOL:${ACTIVE_HANDEYE_WERROR}>:/WX>)
    return()
  endif()
  target_compile_options(${target} PRIVATE
    -Wall -Wextra -Wpedantic -Wshadow -Wundef -Wmissing-declarations -Wnon-virtual-dtor -Woverloaded-virtual
    $<$<BOOL:${ACTIVE_HANDEYE_WERROR}>:-Werror>)
endfunction()
