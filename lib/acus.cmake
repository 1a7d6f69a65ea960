# Build rules shared by the whole tree: compiler settings, one target per module, one program per file.
include(GNUInstallDirs)

find_program(ACUS_CCACHE ccache)
if(ACUS_CCACHE)
  # Precompiled headers are known by their contents, not by the times of their files.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros
                                  ${ACUS_CCACHE})
endif()
find_program(ACUS_MOLD mold)
if(ACUS_MOLD)
  add_link_options(-fuse-ld=mold)
endif()

set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

add_library(acus_flags INTERFACE)
target_compile_features(acus_flags INTERFACE cxx_std_20)
# -ffp-contract=off: the same source must give the same bits, whether or not the compiler finds an FMA.
# Warnings are ours: whoever builds against an installed Acus chooses their own.
target_compile_options(acus_flags INTERFACE
  "$<BUILD_INTERFACE:-Wall;-Wextra;-Wshadow;-Wconversion;-Wno-sign-conversion>"
  "$<BUILD_INTERFACE:$<$<CXX_COMPILER_ID:GNU>:-Werror>>"
  -ffp-contract=off)
# Assertions name their file: from the root of the sources, not by a folder of whoever built.
target_compile_options(acus_flags INTERFACE "$<BUILD_INTERFACE:-ffile-prefix-map=${CMAKE_SOURCE_DIR}/=>")
target_include_directories(acus_flags INTERFACE $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}/lib>
                                                $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)

# No RUNPATH, neither built nor installed: programs find their libraries where the system keeps them.
# CMake would join the folders of imported libraries, and an empty entry among them (that of HDF5
# ends in a colon) is the working directory to the loader: what lies there would run
# (tests/checks/library_path_test.cpp).
set(CMAKE_SKIP_RPATH TRUE)

if(ACUS_SANITIZE STREQUAL "address")
  # What the left-out checks of undefined behaviour see, the address sanitizer stops at as well.
  set(sanitizers -fsanitize=address,undefined,float-cast-overflow
                 -fno-sanitize=null,object-size,vptr
                 -fno-sanitize-recover=all -fno-omit-frame-pointer)
elseif(ACUS_SANITIZE STREQUAL "thread")
  set(sanitizers -fsanitize=thread -fno-sanitize-recover=all -fno-omit-frame-pointer)
elseif(ACUS_SANITIZE STREQUAL "fuzz")  # For tests/fuzz; Clang only.
  set(sanitizers -fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=all
                 -fno-omit-frame-pointer)
  set(with_clang "SHELL:-fgnuc-version=10.2.0 -include ${CMAKE_SOURCE_DIR}/tests/fuzz/itk_with_clang.h")
  add_compile_options("$<$<COMPILE_LANGUAGE:CXX>:${with_clang}>")
elseif(NOT ACUS_SANITIZE STREQUAL "")
  message(FATAL_ERROR "ACUS_SANITIZE is '${ACUS_SANITIZE}'; allowed: empty, address, thread, fuzz")
endif()
if(sanitizers)
  # -O1 compiles in half the time, and reports name the right lines.
  add_compile_options(-O1 ${sanitizers} -g1 -Wno-maybe-uninitialized)
  add_link_options(${sanitizers})
  add_compile_definitions(_GLIBCXX_ASSERTIONS)
endif()

# acus_join_sources(TARGET): compiles several sources as one translation unit. Most of the time of a
# compiler goes into the same templates of Eigen and JSON in each; this halves a build and more.
function(acus_join_sources target)
  if(ACUS_UNITY)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${ACUS_UNITY})
    # A class in a source may hold types of its anonymous namespace: it is still seen only there.
    target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
  endif()
endfunction()

# acus_precompile(NAME [LIBRARY...]): headers of others that nearly every source reads, compiled once
# with the present options, for acus_use_precompiled(TARGET NAME). A source still includes all that it
# uses: -DACUS_PRECOMPILE=OFF builds without.
function(acus_precompile name)
  if(NOT ACUS_PRECOMPILE)
    return()
  endif()
  set(source ${CMAKE_BINARY_DIR}/generated/${name}.cpp)
  file(CONFIGURE OUTPUT ${source} CONTENT "")
  add_library(${name} OBJECT ${source})
  target_link_libraries(${name} PRIVATE acus_flags Eigen3::Eigen nlohmann_json::nlohmann_json ${ARGN})
  target_precompile_headers(${name} PRIVATE
    <algorithm> <array> <atomic> <chrono> <cmath> <condition_variable> <filesystem> <fstream>
    <functional> <limits> <map> <memory> <mutex> <numbers> <numeric> <optional> <random> <ranges>
    <set> <span> <sstream> <string> <string_view> <thread> <tuple> <variant> <vector>
    <Eigen/Dense> <nlohmann/json.hpp>)
endfunction()

function(acus_use_precompiled target name)
  if(ACUS_PRECOMPILE)
    target_precompile_headers(${target} REUSE_FROM ${name})
  endif()
endfunction()

# "wing module dependency dependency ...", a module a row, wings from the lowest to the highest.
set(ACUS_MODULE_GRAPH ${CMAKE_BINARY_DIR}/modules.txt)
file(WRITE ${ACUS_MODULE_GRAPH} "")

# acus_add_wing(NAME): the modules that follow lie in lib/acus/NAME.
macro(acus_add_wing name)
  set(ACUS_WING ${name})
endmacro()

# Where a module lies. A wing of one module is that module.
function(acus_module_folder module out)
  if(module STREQUAL ACUS_WING)
    set(${out} acus/${module} PARENT_SCOPE)
  else()
    set(${out} acus/${ACUS_WING}/${module} PARENT_SCOPE)
  endif()
endfunction()

# acus_compile_alone(MODULE file...): sources that cannot share a translation unit with others: macros of
# X11, code that Highway compiles several times, two vendors' interfaces under the same names.
function(acus_compile_alone module)
  acus_module_folder(${module} folder)
  list(TRANSFORM ARGN PREPEND ${folder}/)
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION TRUE
                                                 SKIP_PRECOMPILE_HEADERS TRUE)
endfunction()

# acus_optimise(MODULE file...): sources of the wing's module MODULE whose loops are worth -O3.
function(acus_optimise module)
  acus_module_folder(${module} folder)
  list(TRANSFORM ARGN PREPEND ${folder}/)
  set_source_files_properties(${ARGN} PROPERTIES COMPILE_OPTIONS $<$<NOT:$<CONFIG:Debug>>:-O3>
                              SKIP_UNITY_BUILD_INCLUSION TRUE SKIP_PRECOMPILE_HEADERS TRUE)
endfunction()

# acus_missing(OUT [DEPENDS module...] [LIBRARIES target...]): the libraries that are not there and that
# the modules or the list need, each once.
function(acus_missing out)
  cmake_parse_arguments(arg "" "" "DEPENDS;LIBRARIES" ${ARGN})
  list(REMOVE_ITEM arg_LIBRARIES ${CMAKE_DL_LIBS})  # Not a target, and in every C library.
  set(missing "")
  foreach(module IN LISTS arg_DEPENDS)
    get_property(of_module GLOBAL PROPERTY ACUS_MISSING_${module})
    list(APPEND missing ${of_module})
  endforeach()
  foreach(library IN LISTS arg_LIBRARIES)
    if(NOT TARGET ${library})
      list(APPEND missing ${library})
    endif()
  endforeach()
  list(REMOVE_DUPLICATES missing)
  set(${out} "${missing}" PARENT_SCOPE)
endfunction()

# acus_report_left_out(): which programs are not built, and what each needs.
function(acus_report_left_out)
  get_property(rows GLOBAL PROPERTY ACUS_LEFT_OUT)
  if(rows)
    list(JOIN rows "\n  " rows)
    message(NOTICE "Not built, because libraries are missing:\n  ${rows}")
  endif()
endfunction()

# acus_add_module(NAME [DEPENDS module...] [LIBRARIES target...] [PRIVATE_LIBRARIES target...])
#
# One static library from all sources of the wing's folder NAME. DEPENDS is the whole list of modules
# whose headers it may include; a test holds every #include against it.
# LIBRARIES appear in public headers, PRIVATE_LIBRARIES only in sources. Left out if a library is missing.
function(acus_add_module name)
  cmake_parse_arguments(arg "" "" "DEPENDS;LIBRARIES;PRIVATE_LIBRARIES" ${ARGN})
  list(JOIN arg_DEPENDS " " row)
  file(APPEND ${ACUS_MODULE_GRAPH} "${ACUS_WING} ${name} ${row}\n")
  acus_missing(missing DEPENDS ${arg_DEPENDS} LIBRARIES ${arg_LIBRARIES} ${arg_PRIVATE_LIBRARIES})
  if(missing)
    set_property(GLOBAL PROPERTY ACUS_MISSING_${name} ${missing})
    return()
  endif()
  set_property(GLOBAL APPEND PROPERTY ACUS_LIBRARIES ${arg_LIBRARIES} ${arg_PRIVATE_LIBRARIES})
  acus_module_folder(${name} folder)
  # A module of many parts has a folder for each of them.
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${folder}/*.cpp
       ${CMAKE_CURRENT_SOURCE_DIR}/${folder}/*/*.cpp)
  if(NOT sources)
    message(FATAL_ERROR "lib/${folder} has no source file")
  endif()
  add_library(acus_${name} STATIC ${sources})
  add_library(acus::${name} ALIAS acus_${name})
  list(TRANSFORM arg_DEPENDS PREPEND acus:: OUTPUT_VARIABLE dependencies)
  target_link_libraries(acus_${name} PUBLIC acus_flags ${dependencies} ${arg_LIBRARIES}
                        PRIVATE ${arg_PRIVATE_LIBRARIES})
  acus_join_sources(acus_${name})
  acus_use_precompiled(acus_${name} acus_headers)
  set_target_properties(acus_${name} PROPERTIES EXPORT_NAME ${name})
  install(TARGETS acus_${name} EXPORT AcusTargets
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}/acus COMPONENT library)
endfunction()

# acus_install_library(): headers, libraries and what find_package(Acus) reads.
function(acus_install_library)
  set_target_properties(acus_flags PROPERTIES EXPORT_NAME flags)
  install(TARGETS acus_flags EXPORT AcusTargets COMPONENT library)
  install(DIRECTORY ${CMAKE_SOURCE_DIR}/lib/acus DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
          COMPONENT library FILES_MATCHING PATTERN "*.h")
  set(folder ${CMAKE_INSTALL_LIBDIR}/cmake/Acus)
  install(EXPORT AcusTargets NAMESPACE acus:: DESTINATION ${folder} COMPONENT library)
  include(CMakePackageConfigHelpers)
  write_basic_package_version_file(${CMAKE_BINARY_DIR}/AcusConfigVersion.cmake
                                   COMPATIBILITY SameMinorVersion)
  # The libraries that were there must be there again; those of modules that are left out need not.
  get_property(ACUS_LIBRARIES GLOBAL PROPERTY ACUS_LIBRARIES)
  list(REMOVE_DUPLICATES ACUS_LIBRARIES)
  list(REMOVE_ITEM ACUS_LIBRARIES ${CMAKE_DL_LIBS})
  configure_file(${CMAKE_SOURCE_DIR}/lib/AcusConfig.cmake.in ${CMAKE_BINARY_DIR}/AcusConfig.cmake @ONLY)
  install(FILES ${CMAKE_BINARY_DIR}/AcusConfig.cmake
                ${CMAKE_SOURCE_DIR}/lib/acus_dependencies.cmake
                ${CMAKE_BINARY_DIR}/AcusConfigVersion.cmake
          DESTINATION ${folder} COMPONENT library)
endfunction()

add_custom_target(programs)

# acus_add_program(NAME module...): the program apps/NAME.cpp, built on the given modules and installed.
# Left out if a library is missing; an OPTIONAL one without consequences for the tests.
function(acus_add_program name)
  cmake_parse_arguments(arg "OPTIONAL" "" "" ${ARGN})
  set(modules ${arg_UNPARSED_ARGUMENTS})
  acus_missing(missing DEPENDS ${modules})
  if(missing)
    acus_debian_packages(packages ${missing})
    if(arg_OPTIONAL)
      message(NOTICE "Not built: ${name}, which needs ${packages}. All else is complete without it.")
      return()
    endif()
    set_property(GLOBAL APPEND PROPERTY ACUS_LEFT_OUT "${name}: ${packages}")
    return()
  endif()
  add_executable(${name} ${CMAKE_CURRENT_SOURCE_DIR}/${name}.cpp)
  list(TRANSFORM modules PREPEND acus::)
  target_link_libraries(${name} PRIVATE acus_flags CLI11::CLI11 ${modules} large_arrays)
  acus_use_precompiled(${name} acus_headers)
  add_dependencies(programs ${name})
  set_property(GLOBAL APPEND PROPERTY ACUS_PROGRAMS ${name})
  # A component each, so that those that are built can be installed by themselves.
  install(TARGETS ${name} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT ${name})
endfunction()

# Sets OUT to the schema of scenarios with configs/schema/effects/KEY.json as the effect KEY.
function(acus_scenario_schema out text)
  foreach(effect ${ARGN})
    get_filename_component(key ${effect} NAME_WE)
    file(READ ${effect} part)
    string(JSON text SET "${text}" properties effects properties ${key} "${part}")
  endforeach()
  set(${out} "${text}" PARENT_SCOPE)
endfunction()

# Compiles configs/schema/*.schema.json into TARGET, so that a program never runs without its schema.
function(acus_embed_schemas target)
  file(GLOB schemas CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/configs/schema/*.schema.json)
  file(GLOB effects CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/configs/schema/effects/*.json)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${schemas} ${effects})
  set(rows "")
  foreach(schema ${schemas})
    get_filename_component(name ${schema} NAME)
    string(REPLACE ".schema.json" "" name ${name})
    file(READ ${schema} text)
    if(name STREQUAL "acus-scenario")
      acus_scenario_schema(text "${text}" ${effects})
    endif()
    string(APPEND rows "    {\"${name}\", R\"SCHEMA(${text})SCHEMA\"},\n")
  endforeach()
  set(source ${CMAKE_BINARY_DIR}/generated/schemas.cpp)
  file(CONFIGURE OUTPUT ${source} @ONLY CONTENT [[
#include "acus/base/config/schemas.h"

namespace acus::config {
namespace {
constexpr EmbeddedSchema kSchemas[] = {
@rows@};
}  // namespace
std::span<const EmbeddedSchema> EmbeddedSchemas() { return kSchemas; }
}  // namespace acus::config
]])
  target_sources(${target} PRIVATE ${source})
endfunction()

# Compiles the style sheet of pages into TARGET: a report is one file.
function(acus_embed_style target)
  set(sheet ${CMAKE_SOURCE_DIR}/pipelines/common/page.css)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${sheet})
  file(READ ${sheet} text)
  set(source ${CMAKE_BINARY_DIR}/generated/page_style.cpp)
  file(CONFIGURE OUTPUT ${source} @ONLY CONTENT [[
#include "acus/base/report/html_parts.h"

namespace acus::report {
std::string_view StyleSheet() { return R"css(@text@)css"; }
}  // namespace acus::report
]])
  target_sources(${target} PRIVATE ${source})
endfunction()

# acus_name_build(TARGET): compiles into TARGET which build it is. Every build looks, since a commit
# does not configure anew; what depends on it is compiled again only when the name has changed.
function(acus_name_build target)
  set(source ${CMAKE_BINARY_DIR}/generated/version.cpp)
  add_custom_target(build_name BYPRODUCTS ${source} VERBATIM COMMENT ""
    COMMAND ${CMAKE_COMMAND} -D SOURCE=${CMAKE_SOURCE_DIR} -D VERSION=${PROJECT_VERSION}
            -D OUTPUT=${source} -P ${CMAKE_SOURCE_DIR}/lib/version.cmake)
  # By itself: a new commit compiles these few lines, and not what they would be joined with.
  set_source_files_properties(${source} PROPERTIES GENERATED TRUE SKIP_UNITY_BUILD_INCLUSION TRUE)
  target_sources(${target} PRIVATE ${source})
  add_dependencies(${target} build_name)
endfunction()
