#include "acus/physics/tissue/tissue_load.h"

#include <gtest/gtest.h>

namespace acus::tissue {
namespace {

TEST(TissueLoad, IsEmptyAtFirst) {
  const TissueLoad load;
  EXPECT_EQ(load.num_points, 0);
  EXPECT_FALSE(load.needle.in_contact);
  EXPECT_EQ(load.needle.axis_in_ct.norm(), 1.0);
}

}  // namespace
}  // namespace acus::tissue
