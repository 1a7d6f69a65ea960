// Labels of a scene of surfaces from voxels of several sizes and from its triangles.
#pragma once

#include "benchmarks/sweep.h"

namespace acus::benchmarks {

Sweep SurfacesSweep();

}  // namespace acus::benchmarks
