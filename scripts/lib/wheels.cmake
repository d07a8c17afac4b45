# The targets that the ROS 2 wheels export carry include paths of the machine they were built on
# (/opt/python/...). At the end of each directory's configuration, replace these by the paths of
# this Python and NumPy. Passed to colcon as CMAKE_PROJECT_TOP_LEVEL_INCLUDES.

function(repair_imported_include_directories)
  get_property(targets DIRECTORY PROPERTY IMPORTED_TARGETS)
  foreach(target IN LISTS targets)
    get_target_property(paths ${target} INTERFACE_INCLUDE_DIRECTORIES)
    if(paths MATCHES "/opt/python/")
      list(FILTER paths EXCLUDE REGEX "^/opt/python/")
      list(APPEND paths ${Python3_INCLUDE_DIRS} ${Python3_NumPy_INCLUDE_DIRS})
      set_target_properties(${target} PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${paths}")
    endif()
  endforeach()
endfunction()

cmake_language(DEFER CALL repair_imported_include_directories)
