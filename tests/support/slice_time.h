// What a slice by VTK costs: how fast the machine is now, whatever it is.
#pragma once

#include "support/paired_times.h"
#include "support/reslice_scene.h"
#include "support/vtk_reslice.h"

namespace acus::testing_support {

/// Of the machine on which limits in microseconds were set: there 190 images a second were measured
/// that take 2.8 slices of two threads.
inline constexpr double kSliceCpuMsOfLimits = 3.8;

/// CPU time on one core of 512 x 512 pixels through a CT; the least of many.
inline double SliceCpuMs() {
  static const volume::CtVolume ct = AbdomenCt();
  VtkReslice reslice(ct, acoustics::ImageOf(FullLinearProbe()), 1,
                     VtkReslice::Threads::kMultiThreader);
  LeastTime least;
  for (int n = 0; n < 60; ++n) least.Add([&] { reslice.Render(SwayingProbe(n)); });
  return least.cpu_ms;
}

}  // namespace acus::testing_support
