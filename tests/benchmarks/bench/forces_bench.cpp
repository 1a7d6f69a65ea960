// What a full force step costs, model by model, in CPU time of the thread: median and 99.9 %.
// Run: build/tests/bench_forces
#include <cstdio>

#include "acus/base/core/cpu_time.h"
#include "acus/base/math/statistics.h"
#include "support/allocation_counter.h"
#include "support/force_scenes.h"

namespace acus::forces {
namespace {

using Eigen::Vector3d;
using testing_support::DrivenAlamilla;
using testing_support::DrivenLayered;
using testing_support::DrivenProbe;
using testing_support::DrivenVidal;
using testing_support::LayeredBodyField;
using testing_support::ShippedTable;
using testing_support::Trocar18G;

constexpr int kSteps = 200000;

/// The body as a CT, so that the cost of reading it counts: 0.7 mm voxels, 360 x 360 x 120 mm.
volume::CtVolume CtOf(const LayeredBodyField& body) {
  volume::Geometry geometry;
  geometry.size = {512, 512, 170};
  geometry.spacing_mm = {0.7, 0.7, 0.7};
  geometry.origin_mm = {-179.0, -179.0, -20.0};
  volume::CtVolume ct(geometry);
  for (int k = 0; k < geometry.size[2]; ++k) {
    const double hu = body.HuAt({0, 0, geometry.origin_mm[2] + 0.7 * k});
    for (int j = 0; j < geometry.size[1]; ++j) {
      for (int i = 0; i < geometry.size[0]; ++i) {
        ct.At(i, j, k) = static_cast<std::int16_t>(hu + (i * 7 + j * 13) % 11 - 5);
      }
    }
  }
  return ct;
}

/// In, out and across, at up to 200 mm/s, with a tremor.
Vector3d Place(int n) {
  const double t = 0.001 * n;
  return {3.0 * std::sin(0.7 * t), 2.0 * std::cos(0.9 * t),
          17.0 - 20.0 * std::cos(1.9 * t) + 0.1 * std::sin(57.0 * t)};
}

/// Steps in batches of 10: the clock itself takes about 0.2 us.
template <typename Step>
void Measure(const char* name, Step step) {
  constexpr int kBatch = 10;
  std::vector<double> us;
  us.reserve(kSteps / kBatch);
  for (int n = 0; n < 2000; ++n) step(n);
  const long before = testing_support::num_allocations;
  for (int n = 2000; n < kSteps; n += kBatch) {
    const double begin = ThreadCpuSeconds();
    for (int i = 0; i < kBatch; ++i) step(n + i);
    us.push_back(1e6 * (ThreadCpuSeconds() - begin) / kBatch);
  }
  const long allocations = testing_support::num_allocations - before;
  std::printf("%-10s median %.3f us, 99.9 %% %.3f us, %ld allocations in %d steps\n", name,
              math::Median(us), math::Quantile(us, 0.999), allocations, kSteps);
}

int Run() {
  const LayeredBodyField body = testing_support::Abdomen();
  const volume::CtVolume ct = CtOf(body);
  const CtField field(ct);
  const NeedleForceModel layered(ShippedTable("default.json"), Trocar18G());
  const AlamillaModel alamilla(ShippedTable("alamilla.json"), Trocar18G());
  const VidalModel vidal(ShippedTable("vidal.json"), Trocar18G(), field);
  const VidalProbe probe(ShippedTable("vidal.json"), field);
  DrivenLayered a{layered, body};
  DrivenAlamilla b{alamilla, body};
  DrivenVidal c{vidal, body};
  DrivenProbe d{probe};
  Measure("layered", [&](int n) { a.Step(0.001 * n, Place(n)); });
  Measure("alamilla", [&](int n) { b.Step(0.001 * n, Place(n)); });
  Measure("vidal", [&](int n) { c.Step(0.001 * n, Place(n)); });
  Measure("probe", [&](int n) { d.Step(0.001 * n, 0.6 * Place(n)); });
  return 0;
}

}  // namespace
}  // namespace acus::forces

int main() {
  return acus::forces::Run();
}
