# Build rules shared by the whole tree: compiler settings, one target per module, one program per file.
include(GNUInstallDirs)

find_program(ACUS_CCACHE ccache)
if(ACUS_CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${ACUS_CCACHE})
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
target_compile_options(acus_flags INTERFACE
  -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion -Werror -ffp-contract=off)
target_include_directories(acus_flags INTERFACE ${CMAKE_SOURCE_DIR}/lib)

if(ACUS_SANITIZE STREQUAL "address")
  set(sanitizers -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer)
elseif(ACUS_SANITIZE STREQUAL "thread")
  set(sanitizers -fsanitize=thread -fno-sanitize-recover=all -fno-omit-frame-pointer)
elseif(NOT ACUS_SANITIZE STREQUAL "")
  message(FATAL_ERROR "ACUS_SANITIZE is '${ACUS_SANITIZE}'; allowed: empty, address, thread")
endif()
if(sanitizers)
  set(CMAKE_CXX_FLAGS_RELEASE "-O1")  # Compiles in half the time, and reports name the right lines.
  add_compile_options(${sanitizers} -g1 -Wno-maybe-uninitialized)
  add_link_options(${sanitizers})
  add_compile_definitions(_GLIBCXX_ASSERTIONS)
endif()

set(ACUS_MODULE_GRAPH ${CMAKE_BINARY_DIR}/modules.txt)
file(WRITE ${ACUS_MODULE_GRAPH} "")

# acus_add_module(NAME [DEPENDS module...] [LIBRARIES target...] [PRIVATE_LIBRARIES target...])
#
# One static library from all sources in lib/NAME. DEPENDS is the whole list of modules whose headers
# lib/NAME may include; a test holds every #include against it (modules.txt: "name dep dep ...").
# LIBRARIES appear in public headers, PRIVATE_LIBRARIES only in sources.
function(acus_add_module name)
  cmake_parse_arguments(arg "" "" "DEPENDS;LIBRARIES;PRIVATE_LIBRARIES" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${name}/*.cpp)
  if(NOT sources)
    message(FATAL_ERROR "lib/${name} has no source file")
  endif()
  add_library(acus_${name} STATIC ${sources})
  add_library(acus::${name} ALIAS acus_${name})
  list(TRANSFORM arg_DEPENDS PREPEND acus:: OUTPUT_VARIABLE dependencies)
  target_link_libraries(acus_${name} PUBLIC acus_flags ${dependencies} ${arg_LIBRARIES}
                        PRIVATE ${arg_PRIVATE_LIBRARIES})
  list(JOIN arg_DEPENDS " " row)
  file(APPEND ${ACUS_MODULE_GRAPH} "${name} ${row}\n")
endfunction()

add_custom_target(programs)

# acus_add_program(NAME module...): the program apps/NAME.cpp, built on the given modules and installed.
function(acus_add_program name)
  add_executable(${name} ${CMAKE_CURRENT_SOURCE_DIR}/${name}.cpp)
  list(TRANSFORM ARGN PREPEND acus:: OUTPUT_VARIABLE modules)
  target_link_libraries(${name} PRIVATE acus_flags CLI11::CLI11 ${modules})
  add_dependencies(programs ${name})
  set_property(GLOBAL APPEND PROPERTY ACUS_PROGRAMS ${name})
  install(TARGETS ${name} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endfunction()

# Compiles configs/schema/*.schema.json into TARGET, so that a program never runs without its schema.
function(acus_embed_schemas target)
  file(GLOB schemas CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/configs/schema/*.schema.json)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${schemas})
  set(rows "")
  foreach(schema ${schemas})
    get_filename_component(name ${schema} NAME)
    string(REPLACE ".schema.json" "" name ${name})
    file(READ ${schema} text)
    string(APPEND rows "    {\"${name}\", R\"SCHEMA(${text})SCHEMA\"},\n")
  endforeach()
  set(source ${CMAKE_BINARY_DIR}/generated/schemas.cpp)
  file(CONFIGURE OUTPUT ${source} @ONLY CONTENT [[
#include "config/schemas.h"

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
