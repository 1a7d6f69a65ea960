# The libraries that modules are linked with, for this build and for find_package(Acus).
set(CMAKE_FIND_PACKAGE_TARGETS_GLOBAL TRUE)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(CLI11 REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(Boost REQUIRED)  # Headers only: distributions.
find_package(EXPAT REQUIRED)
find_package(Threads REQUIRED)
find_package(OpenSSL REQUIRED COMPONENTS Crypto)
find_package(ZLIB REQUIRED)
find_package(PNG REQUIRED)
# ITK, VTK, OpenCV and TetGen stay inside sources: PRIVATE_LIBRARIES, never in a header.
find_package(ITK 5.2 REQUIRED COMPONENTS
             ITKCommon ITKGDCM ITKIOImageBase ITKIONIFTI ITKIONRRD ITKIOMeta ITKIOTransformBase
             ITKIOTransformInsightLegacy ITKIOTransformHDF5 ITKSmoothing ITKThresholding
             ITKConnectedComponents ITKBinaryMathematicalMorphology ITKDistanceMap ITKLabelMap
             ITKRegionGrowing ITKLevelSets ITKImageGrid ITKImageFunction ITKAnisotropicSmoothing)
find_package(VTK 9.1 REQUIRED COMPONENTS
             CommonCore CommonDataModel FiltersCore FiltersGeneral FiltersModeling IOLegacy IOXML IOGeometry
             IOPLY IOImage ImagingCore RenderingCore RenderingOpenGL2 RenderingFreeType RenderingUI
             InteractionStyle)
find_package(OpenCV 4.6 REQUIRED GLOBAL COMPONENTS core imgproc imgcodecs videoio calib3d aruco)
find_package(Ceres 2.1 REQUIRED)
find_package(embree 3.13 REQUIRED)  # Rays against triangles.
find_package(hwy REQUIRED GLOBAL)  # Global: the tests choose instruction sets.
find_package(PkgConfig REQUIRED)
pkg_check_modules(libav REQUIRED IMPORTED_TARGET libavformat libavcodec libavutil)
find_package(HDF5 REQUIRED COMPONENTS C)
pkg_check_modules(matio REQUIRED IMPORTED_TARGET matio)
pkg_check_modules(sndfile REQUIRED IMPORTED_TARGET GLOBAL sndfile)  # Global: tests write other formats.
find_library(ACUS_ZIP zip REQUIRED)  # libzip's own package file asks for tools that it does not need.
# OpenIGTLink's own USE_FILE sets compiler flags that break others: a target of our own instead.
find_library(ACUS_OPENIGTLINK OpenIGTLink REQUIRED)
find_path(ACUS_OPENIGTLINK_INCLUDE igtl_header.h PATH_SUFFIXES openigtlink REQUIRED)
add_library(OpenIGTLink::Library UNKNOWN IMPORTED GLOBAL)
set_target_properties(OpenIGTLink::Library PROPERTIES IMPORTED_LOCATION ${ACUS_OPENIGTLINK}
                      INTERFACE_INCLUDE_DIRECTORIES ${ACUS_OPENIGTLINK_INCLUDE})
# Sparse Cholesky. OpenBLAS by name, to hold it to one thread: it is slower with two.
find_library(ACUS_CHOLMOD cholmod REQUIRED)
find_library(ACUS_OPENBLAS openblas REQUIRED)
find_path(ACUS_SUITESPARSE_INCLUDE cholmod.h PATH_SUFFIXES suitesparse REQUIRED)
# What a window needs: VTK finds its OpenGL, X and fonts at link time, by vtk_module_autoinit.
find_package(X11 REQUIRED)
# What casts rays on a graphics card: contexts without a window.
find_package(OpenGL REQUIRED COMPONENTS OpenGL EGL)
