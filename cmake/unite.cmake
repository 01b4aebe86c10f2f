# Optimisation levels by folder, and sources compiled several at a time. Most of the time to compile
# a small source goes into the headers, so this halves the first build.
#
# Names in anonymous namespaces must differ within a folder. Each test has a namespace of its own.
# -DKIBORI_UNITE=OFF compiles each source alone, as clang-tidy needs it.
option(KIBORI_UNITE "Compile several sources of a folder at once" ON)

# Sets the compile options of the sources of a target in folders (a regular expression), for the
# build type Release. To be called before kibori_unite.
function(kibori_optimize target options folders)
  get_target_property(sources ${target} SOURCES)
  list(FILTER sources INCLUDE REGEX "/(${folders})/[^/]*\\.cpp$")
  set_property(SOURCE ${sources} PROPERTY KIBORI_OPTIONS "$<$<CONFIG:Release>:${options}>")
endfunction()

# Groups the sources of a target by folder and options, up to six in a group. Sources with own
# compile options or definitions, and vector kernels, which include themselves, stay alone.
function(kibori_unite target)
  get_target_property(sources ${target} SOURCES)
  list(FILTER sources INCLUDE REGEX "\\.cpp$")
  list(REMOVE_DUPLICATES sources)
  foreach(source ${sources})
    cmake_path(ABSOLUTE_PATH source)
    get_source_file_property(options ${source} KIBORI_OPTIONS)
    file(STRINGS ${source} kernel REGEX "foreach_target" LIMIT_COUNT 1)
    if(kernel OR NOT KIBORI_UNITE)
      set_source_files_properties(${source} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
      if(options)
        set_property(SOURCE ${source} APPEND PROPERTY COMPILE_OPTIONS ${options})
      endif()
      continue()
    endif()
    cmake_path(GET source PARENT_PATH group)
    cmake_path(RELATIVE_PATH group BASE_DIRECTORY ${PROJECT_SOURCE_DIR})
    string(REPLACE "/" "_" group ${group})
    math(EXPR count_${group} "${count_${group}} + 1")
    math(EXPR part "(${count_${group}} - 1) / 6")
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${group}_${part})
    if(options)
      set_source_files_properties(${CMAKE_CURRENT_BINARY_DIR}/CMakeFiles/${target}.dir/Unity/unity_${group}_${part}_cxx.cxx
        PROPERTIES COMPILE_OPTIONS "${options}")
    endif()
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${KIBORI_UNITE} UNITY_BUILD_MODE GROUP)
  # GCC takes an included source for a header, whose types must not use anonymous namespaces.
  target_compile_options(${target} PRIVATE $<$<AND:$<BOOL:${KIBORI_UNITE}>,$<CXX_COMPILER_ID:GNU>>:-Wno-subobject-linkage>)
endfunction()
