# find_package(Acus): targets acus::core, acus::simulation, ... one per module (docs/library.md).
cmake_minimum_required(VERSION 3.25)
include(${CMAKE_CURRENT_LIST_DIR}/acus_dependencies.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/AcusTargets.cmake)
