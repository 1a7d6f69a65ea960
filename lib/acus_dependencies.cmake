# The libraries that modules are linked with, for this build and for find_package(Acus). What every
# program is made of is required. A module whose libraries are not there is left out, and the programs
# that are linked with it (acus_missing in acus.cmake).
set(CMAKE_FIND_PACKAGE_TARGETS_GLOBAL TRUE)
enable_language(C)  # The package files of HDF5 and ITK try it.
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(CLI11 REQUIRED)
find_package(nlohmann_json REQUIRED)
find_path(ACUS_VALIJSON valijson/schema.hpp REQUIRED)
find_package(Boost REQUIRED)  # Headers only: distributions.
find_package(EXPAT REQUIRED)
find_package(Threads REQUIRED)
find_package(OpenSSL REQUIRED COMPONENTS Crypto)

# acus_find(NAME library... HEADER file [folder] [DEFINES name...]): the target acus::with_NAME, for
# libraries that have no usable package file. No target if a library or the header is missing.
function(acus_find name)
  cmake_parse_arguments(arg "" "" "HEADER;DEFINES" ${ARGN})
  set(found "")
  foreach(library IN LISTS arg_UNPARSED_ARGUMENTS)
    string(TOUPPER ACUS_${library} variable)
    find_library(${variable} ${library})
    list(APPEND found ${${variable}})
  endforeach()
  list(POP_FRONT arg_HEADER header)
  string(TOUPPER ACUS_${name}_INCLUDE include)
  find_path(${include} ${header} PATH_SUFFIXES ${arg_HEADER})
  foreach(path IN LISTS found ITEMS ${${include}})
    if(NOT path)
      return()
    endif()
  endforeach()
  if(NOT TARGET acus::with_${name})
    add_library(acus::with_${name} INTERFACE IMPORTED GLOBAL)
    set_target_properties(acus::with_${name} PROPERTIES
      INTERFACE_LINK_LIBRARIES "${found}" INTERFACE_INCLUDE_DIRECTORIES "${${include}}"
      INTERFACE_COMPILE_DEFINITIONS "${arg_DEFINES}")
  endif()
endfunction()

find_package(ZLIB QUIET)
find_package(PNG QUIET)
# ITK, VTK, OpenCV and TetGen stay inside sources: PRIVATE_LIBRARIES, never in a header.
find_package(ITK 5.2 QUIET COMPONENTS
             ITKCommon ITKIOImageBase ITKIONIFTI ITKIONRRD ITKIOMeta
             ITKGDCM ITKSmoothing ITKRegionGrowing ITKLevelSets)
if(ITK_FOUND AND NOT TARGET acus::with_itk)
  add_library(acus::with_itk INTERFACE IMPORTED GLOBAL)
  set_target_properties(acus::with_itk PROPERTIES INTERFACE_LINK_LIBRARIES "${ITK_LIBRARIES}"
                        INTERFACE_INCLUDE_DIRECTORIES "${ITK_INCLUDE_DIRS}")
endif()
# What a window needs: VTK finds its OpenGL, X and fonts at link time, by vtk_module_autoinit.
find_package(VTK 9.1 QUIET COMPONENTS CommonCore CommonDataModel IOLegacy IOXML
             OPTIONAL_COMPONENTS FiltersCore RenderingCore RenderingOpenGL2 RenderingFreeType
                                 RenderingUI InteractionStyle)
find_package(OpenCV 4.6 QUIET GLOBAL COMPONENTS core imgproc
             OPTIONAL_COMPONENTS imgcodecs videoio calib3d aruco)
find_package(Ceres 2.1 QUIET)
find_package(embree 3.13 QUIET)  # Rays against triangles.
find_package(hwy QUIET GLOBAL)  # Global: the tests choose instruction sets.
find_package(PkgConfig QUIET)
if(PkgConfig_FOUND)
  pkg_check_modules(libav QUIET IMPORTED_TARGET GLOBAL libavformat libavcodec libavutil)
  pkg_check_modules(matio QUIET IMPORTED_TARGET GLOBAL matio)
  pkg_check_modules(sndfile QUIET IMPORTED_TARGET GLOBAL sndfile)
endif()
find_package(HDF5 QUIET COMPONENTS C)
acus_find(bz2 bz2 HEADER bzlib.h)
acus_find(zip zip HEADER zip.h)  # Its own package file asks for tools that it does not need.
# Its own USE_FILE sets compiler flags that break others.
acus_find(openigtlink OpenIGTLink HEADER igtl_header.h openigtlink)
# Sparse Cholesky. OpenBLAS by name, to hold it to one thread: it is slower with two.
acus_find(cholmod cholmod openblas HEADER cholmod.h suitesparse)
acus_find(tetgen tet HEADER tetgen.h DEFINES TETLIBRARY)
find_package(X11 QUIET)
find_package(Qt5 5.15 QUIET COMPONENTS Widgets)
# What casts rays on a graphics card: contexts without a window.
find_package(OpenGL QUIET COMPONENTS OpenGL EGL)

# acus_debian_packages(OUT target...): what to install for the targets above, each package once.
function(acus_debian_packages out)
  set(rows "^ZLIB" zlib1g-dev "^PNG" libpng-dev "_itk$" libinsighttoolkit5-dev "^VTK" libvtk9-dev
           "opencv_aruco" libopencv-contrib-dev "^opencv_[^a]" libopencv-dev "^Ceres" libceres-dev
           "^embree" libembree-dev "^hwy" libhwy-dev "libav$" libavformat-dev "matio$" libmatio-dev
           "sndfile$" libsndfile1-dev "^hdf5" libhdf5-dev "_zip$" libzip-dev "_bz2$" libbz2-dev
           "_openigtlink$" libopenigtlink-dev "_cholmod$" "libsuitesparse-dev, libopenblas-dev"
           "_tetgen$" libtet1.5-dev "^Qt5" qtbase5-dev "^X11" libx11-dev "::EGL" libegl-dev "^OpenGL" libopengl-dev)
  set(packages "")
  while(rows)
    list(POP_FRONT rows pattern package)
    set(of_package ${ARGN})
    list(FILTER of_package INCLUDE REGEX "${pattern}")
    if(of_package)
      list(APPEND packages "${package}")
    endif()
  endwhile()
  list(REMOVE_DUPLICATES packages)
  list(JOIN packages ", " packages)
  set(${out} "${packages}" PARENT_SCOPE)
endfunction()
