#include "benchmarks/enough.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "acus/base/core/error.h"

namespace acus::benchmarks {
namespace {

using testing::HasSubstr;

Row Mesh(const std::string& value, double error, double preparation_s) {
  Row row;
  row.knob = "element_size_mm";
  row.value = value;
  row.error = error;
  row.error_unit = "N";
  row.reference = "elements of 2 mm";
  row.step_us_median = 3.0;
  row.preparation_s = preparation_s;
  return row;
}

std::vector<Row> Meshes() {
  return {Mesh("4", 0.7, 0.6), Mesh("3", 0.04, 1.5), Mesh("2.4", 0.03, 3.9), Mesh("2", 0.0, 6.9)};
}

TEST(Enough, IsTheCheapestOfThoseThatAre) {
  const std::string text = EnoughText(Meshes(), 0.05);
  EXPECT_EQ(text,
            "element_size_mm: 3 is enough for 0.05 N: 0.04 N off elements of 2 mm; 3 us per step, "
            "1.5 s of preparation.\n");
}

TEST(Enough, IsNeverTheReferenceItself) {
  EXPECT_THAT(EnoughText(Meshes(), 0.02),
              HasSubstr("no setting measured is enough for 0.02 N; the nearest, 2.4, is 0.03 N"));
}

TEST(Enough, LeavesOutWhatMustNotBeUsedAndOtherUnits) {
  std::vector<Row> rows = Meshes();
  rows[1].unusable = "diverged";
  rows.push_back(Mesh("4", 0.001, 0.1));
  rows.back().error_unit = "%";
  EXPECT_THAT(EnoughText(rows, 0.05), HasSubstr("element_size_mm: 2.4 is enough"));
}

TEST(Enough, ReportsEachKnob) {
  std::vector<Row> rows = Meshes();
  rows.push_back(Mesh("springs", 0.01, 0.0));
  rows.back().knob = "model";
  const std::string text = EnoughText(rows, 0.05);
  EXPECT_THAT(text, HasSubstr("element_size_mm: 3 is enough"));
  EXPECT_THAT(text, HasSubstr("model: springs is enough"));
}

TEST(Enough, RefusesASweepWithoutForces) {
  std::vector<Row> rows = Meshes();
  for (Row& row : rows) row.error_unit = "dB";
  EXPECT_THROW(EnoughText(rows, 0.05), InputError);
}

}  // namespace
}  // namespace acus::benchmarks
