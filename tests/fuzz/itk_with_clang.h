// Included first, when the fuzzers are built (lib/acus.cmake): Debian's ITK was configured for GCC
// alone and refuses Clang, which can read all of it.
#pragma once

#if __has_include(<itk_compiler_detection.h>)
#pragma push_macro("__clang__")
#undef __clang__
#include <itk_compiler_detection.h>
#pragma pop_macro("__clang__")
#endif
