# Helpers that every folder of the project uses: one library per core folder, one executable per node or tool, one test per file.

set(SINEW_WARNINGS -Wall -Wextra -Wconversion -Wshadow)
set(SINEW_SANITIZERS -fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer)

# x86-64-v2 in flags that compilers before its name (gcc 9) know too.
if(SINEW_MARCH)
  set(SINEW_ARCHITECTURE -march=${SINEW_MARCH})
elseif(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  set(SINEW_ARCHITECTURE -msse4.2 -mpopcnt -mcx16)
endif()

function(sinew_compile_options target)
  target_compile_options(${target} PRIVATE ${SINEW_WARNINGS})
  target_compile_options(${target} PRIVATE ${SINEW_ARCHITECTURE})
  target_compile_definitions(${target} PRIVATE EIGEN_STACK_ALLOCATION_LIMIT=1048576)  # the blocks of a product: no heap in a cycle
  if(SINEW_SANITIZE)
    target_compile_options(${target} PRIVATE ${SINEW_SANITIZERS})
    target_link_options(${target} PRIVATE -fsanitize=address,undefined)
  endif()
endfunction()

# sinew_library(<folder> SOURCES a.cpp ... [LINK target ...])
function(sinew_library folder)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
  add_library(sinew_${folder} ${ARG_SOURCES})
  target_include_directories(sinew_${folder} PUBLIC ${PROJECT_SOURCE_DIR}/include)
  target_link_libraries(sinew_${folder} PUBLIC Eigen3::Eigen ${ARG_LINK})
  sinew_compile_options(sinew_${folder})
  install(TARGETS sinew_${folder}
    ARCHIVE DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION}
    LIBRARY DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION}
    RUNTIME DESTINATION ${CATKIN_GLOBAL_BIN_DESTINATION})
endfunction()

# sinew_vectorised(<folder> <source>): compiled into the folder's library once per instruction set, in the namespace SINEW_ISA
function(sinew_vectorised folder source)
  set(flags_plain "")
  set(sets plain)
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    set(flags_plain -msse4.2)
    set(flags_avx2 -mavx2 -mfma)
    set(flags_avx512 -mavx512f -mavx512dq -mavx512vl -mavx2 -mfma)
    list(APPEND sets avx2 avx512)
  endif()
  get_filename_component(noun ${source} NAME_WE)
  foreach(set IN LISTS sets)
    set(objects sinew_${folder}_${noun}_${set})
    add_library(${objects} OBJECT ${source})
    set_target_properties(${objects} PROPERTIES POSITION_INDEPENDENT_CODE ON)
    target_include_directories(${objects} PRIVATE ${PROJECT_SOURCE_DIR}/include)
    target_compile_definitions(${objects} PRIVATE SINEW_ISA=${set})
    target_compile_options(${objects} PRIVATE -O3 ${SINEW_WARNINGS} ${flags_${set}})
    if(SINEW_SANITIZE)
      # The compiler's own headers leave lanes undefined on purpose.
      target_compile_options(${objects} PRIVATE ${SINEW_SANITIZERS} -Wno-maybe-uninitialized)
    endif()
    target_sources(sinew_${folder} PRIVATE $<TARGET_OBJECTS:${objects}>)
  endforeach()
endfunction()

# sinew_executable(<name> SOURCES a.cpp ... [LINK target ...] [ROS]): `rosrun sinew <name>`
function(sinew_executable name)
  cmake_parse_arguments(ARG "ROS" "" "SOURCES;LINK" ${ARGN})
  add_executable(${PROJECT_NAME}_${name} ${ARG_SOURCES})
  set_target_properties(${PROJECT_NAME}_${name} PROPERTIES OUTPUT_NAME ${name} PREFIX "")
  target_link_libraries(${PROJECT_NAME}_${name} PRIVATE ${ARG_LINK})
  sinew_compile_options(${PROJECT_NAME}_${name})
  if(ARG_ROS)
    add_dependencies(${PROJECT_NAME}_${name} ${PROJECT_NAME}_generate_messages_cpp)
    target_include_directories(${PROJECT_NAME}_${name} SYSTEM PRIVATE ${catkin_INCLUDE_DIRS})
    target_link_libraries(${PROJECT_NAME}_${name} PRIVATE ${catkin_LIBRARIES} Threads::Threads)
  endif()
  set_target_properties(${PROJECT_NAME}_${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CATKIN_DEVEL_PREFIX}/${CATKIN_PACKAGE_BIN_DESTINATION})
  install(TARGETS ${PROJECT_NAME}_${name} RUNTIME DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
endfunction()

# sinew_test(<name> SOURCES a.cpp ... [LINK target ...]): a gtest without ROS, named <folder>/<noun>_test.cpp
function(sinew_test name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
  catkin_add_gtest(${name} ${ARG_SOURCES} ${PROJECT_SOURCE_DIR}/test/main.cpp)
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/test)
  target_link_libraries(${name} ${ARG_LINK} ${GTEST_LIBRARIES})
  target_compile_definitions(${name} PRIVATE SINEW_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  sinew_compile_options(${name})
endfunction()
