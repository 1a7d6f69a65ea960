#include "acus/physics/mechanics/elements/dilatation_patches.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <numeric>
#include <set>

#include "support/box_mesh.h"

namespace acus::mechanics {
namespace {

using testing_support::BoxMesh;
using testing_support::Renumbered;

std::vector<int> AllOf(const mesh::TetraMesh& mesh) {
  std::vector<int> all(mesh.tissue.size());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

mesh::TetraMesh LayeredBox() {
  mesh::TetraMesh box = BoxMesh({9, 8, 7}, {0, 0, 0}, {9, 8, 7}, 0.15);
  for (std::size_t t = 0; t < box.tissue.size(); ++t) {
    const double z = box.nodes_mm(2, box.tetrahedra(0, static_cast<int>(t)));
    box.tissue[t] = z < 2.5 ? 3 : z > 5.5 ? 1 : 2;
  }
  return box;
}

TEST(DilatationPatches, HoldEachTetrahedronOnceAndOneTissue) {
  const mesh::TetraMesh box = LayeredBox();
  std::vector<int> seen;
  for (const std::vector<int>& patch : DilatationPatches(box, AllOf(box))) {
    ASSERT_FALSE(patch.empty());
    for (const int t : patch) {
      EXPECT_EQ(box.tissue[t], box.tissue[patch[0]]);
      seen.push_back(t);
    }
  }
  std::ranges::sort(seen);
  EXPECT_EQ(seen, AllOf(box));
}

TEST(DilatationPatches, AreLargeEnoughNotToLockAndBounded) {
  const mesh::TetraMesh box = BoxMesh({12, 12, 12}, {0, 0, 0}, {12, 12, 12}, 0.15);
  const auto patches = DilatationPatches(box, AllOf(box));
  // Three unknowns per node against one constraint per patch.
  EXPECT_LT(static_cast<double>(patches.size()), 0.4 * static_cast<double>(box.nodes_mm.cols()));
  std::size_t largest = 0;
  for (const auto& patch : patches) largest = std::max(largest, patch.size());
  EXPECT_LE(largest, 40u);
}

TEST(DilatationPatches, AreTheSameHoweverNodesAndTetrahedraAreNumbered) {
  const mesh::TetraMesh box = LayeredBox();
  const auto renumbered = Renumbered(box, 17);
  const auto sets = [](const auto& patches, const std::vector<int>& number) {
    std::set<std::set<int>> out;
    for (const auto& patch : patches) {
      std::set<int> numbers;
      for (const int t : patch) numbers.insert(number[t]);
      out.insert(numbers);
    }
    return out;
  };
  EXPECT_EQ(sets(DilatationPatches(box, AllOf(box)), AllOf(box)),
            sets(DilatationPatches(renumbered.mesh, AllOf(box)), renumbered.old_tetrahedron));
}

TEST(DilatationPatches, OmitWhatIsNotRequested) {
  const mesh::TetraMesh box = LayeredBox();
  const std::vector<int> some{3, 4, 5, 100};
  std::vector<int> seen;
  for (const auto& patch : DilatationPatches(box, some)) {
    seen.insert(seen.end(), patch.begin(), patch.end());
  }
  std::ranges::sort(seen);
  EXPECT_EQ(seen, some);
  EXPECT_TRUE(DilatationPatches(box, {}).empty());
}

}  // namespace
}  // namespace acus::mechanics
