#include "acus/scene/effects/fluid/fluid_meter.h"

#include <algorithm>
#include <array>
#include <gmock/gmock.h>

#include "acus/scene/effects/fluid/fluid_stage.h"

namespace acus::effects {
namespace {

using Row = std::array<double, static_cast<std::size_t>(FluidColumn::kCount)>;

Row RowOf(double kpa, double losses, double beyond_mm) {
  Row row{};
  row[static_cast<std::size_t>(FluidColumn::kSyringeKpa)] = kpa;
  row[static_cast<std::size_t>(FluidColumn::kLosses)] = losses;
  row[static_cast<std::size_t>(FluidColumn::kBeyondLossMm)] = beyond_mm;
  return row;
}

std::optional<double> ValueOf(const FluidMeter& meter, const std::string& name) {
  const auto values = meter.Values();
  const auto found = std::ranges::find(values, name, &MeasuredValue::name);
  return found == values.end() ? std::nullopt : std::optional(found->value);
}

TEST(FluidMeter, MeasuresHowFarAndHowLongTheNeedleGoesOnAfterTheLoss) {
  FluidMeter meter;
  meter.Add(0.0, RowOf(40.0, 0.0, 0.0));
  EXPECT_EQ(ValueOf(meter, "advance after the loss of resistance"), 0.0);
  EXPECT_THAT(meter.Findings().front(), testing::HasSubstr("no loss of resistance"));
  meter.Add(1.0, RowOf(60.0, 0.0, 0.0));
  meter.Add(2.0, RowOf(3.0, 1.0, 0.0));
  meter.Add(2.5, RowOf(2.0, 1.0, 1.5));
  meter.Add(3.0, RowOf(2.0, 1.0, 1.0));  // Drawn back.
  EXPECT_EQ(ValueOf(meter, "largest injection pressure"), 60.0);
  EXPECT_EQ(ValueOf(meter, "losses of resistance in the epidural space"), 1.0);
  EXPECT_EQ(ValueOf(meter, "advance after the loss of resistance"), 1.5);
  EXPECT_EQ(ValueOf(meter, "time from the loss of resistance to the stop"), 0.5);
  EXPECT_THAT(meter.Findings().front(), testing::HasSubstr("at 2 s"));
}

TEST(FluidMeter, MeasuresTheMostThatWentIntoTheSpaceAndCameFromIt) {
  FluidMeter meter("renal_pelvis");
  for (const double space_ml : {0.0, 2.0, -3.5, -1.0}) {
    Row row{};
    row[static_cast<std::size_t>(FluidColumn::kSpaceMl)] = space_ml;
    row[static_cast<std::size_t>(FluidColumn::kStyletRemovals)] = 1.0;
    row[static_cast<std::size_t>(FluidColumn::kAspiratedMl)] = 0.5;
    meter.Add(0.0, row);
  }
  EXPECT_EQ(ValueOf(meter, "injected into the space"), 2.0);
  EXPECT_EQ(ValueOf(meter, "drawn from the space"), 3.5);
  EXPECT_EQ(ValueOf(meter, "stylet removals"), 1.0);
  EXPECT_EQ(ValueOf(meter, "aspirated volume"), 0.5);
  // Nobody looks for the epidural space in a kidney.
  EXPECT_THAT(meter.Findings().front(), testing::HasSubstr("Space: renal pelvis"));
  EXPECT_THAT(meter.Findings(), testing::Not(testing::Contains(testing::HasSubstr("epidural"))));
}

TEST(FluidMeter, NamesAPressureThatIsUnsafeNearNerves) {
  FluidMeter meter;
  meter.Add(0.0, RowOf(120.0, 0.0, 0.0));
  EXPECT_THAT(meter.Findings().back(), testing::HasSubstr("15 psi"));
}

}  // namespace
}  // namespace acus::effects
