# sinew_find_library(<PREFIX> <library> <header> <debian package>): <PREFIX>_LIBRARY and <PREFIX>_INCLUDE_DIR, or an error
function(sinew_find_library prefix library header package)
  find_path(${prefix}_INCLUDE_DIR ${header} PATH_SUFFIXES suitesparse)
  find_library(${prefix}_LIBRARY ${library})
  if(NOT ${prefix}_LIBRARY OR NOT ${prefix}_INCLUDE_DIR)
    message(FATAL_ERROR "${library} not found: install ${package}")
  endif()
endfunction()
