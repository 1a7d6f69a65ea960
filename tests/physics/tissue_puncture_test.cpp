// Where the needle pierces membranes is a property of tissue, not of the mesh.
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "acus/physics/mechanics/condensation/condensation.h"
#include "benchmarks/punctures.h"

namespace acus::benchmarks {
namespace {

TEST(TissuePuncture, DoesNotDependOnTheMesh) {
  Provenance provenance;
  const TissueBlockTables tables = TissueBlockTables::FromPresets(provenance);
  const std::vector<double> sizes = {6.0, 4.0, 3.0, 2.0};
  std::vector<std::vector<Puncture>> all;
  for (const double size : sizes) {
    all.push_back(PuncturesWith(size, tables, mechanics::kDefaultMemoryMib));
    std::printf("elements of %.0f mm:", size);
    for (const Puncture& p : all.back()) std::printf("  %.2f mm %.2f N", p.depth_mm, p.force_n);
    std::printf("\n");
    ASSERT_EQ(all.back().size(), 3u) << "skin, muscle, liver";
  }
  for (std::size_t n = 0; n < 3; ++n) {
    const auto compare = [&](std::size_t coarse, std::size_t fine) {
      EXPECT_NEAR(all[coarse][n].depth_mm / all[fine][n].depth_mm, 1.0, 0.05)
          << sizes[coarse] << " to " << sizes[fine] << " mm, puncture " << n;
      EXPECT_NEAR(all[coarse][n].force_n / all[fine][n].force_n, 1.0, 0.05);
    };
    compare(0, 2);
    compare(1, 3);
  }
  // The layered law gives the skin 5 mm, fitted to such curves; a linear skin needs 43.
  EXPECT_LT(all[1][0].depth_mm, 15.0);
}

}  // namespace
}  // namespace acus::benchmarks
