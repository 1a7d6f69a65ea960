#include "acus/physics/fluid/fluid_table.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <set>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "injections.h"

namespace acus::fluid {
namespace {

using nlohmann::json;
using testing_support::kDefaultTable;

std::string ErrorOf(const json& document) {
  try {
    FluidTableFromJson(document, "t.json");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

json Default() {
  return config::ReadJson(kDefaultTable);
}

TEST(FluidTable, HasTheSpacesOfThePunctures) {
  const FluidTable table = ReadFluidTable(kDefaultTable);
  EXPECT_EQ(table.TissueIndex("outside"), 0);
  for (const char* name : {"fat", "muscle", "interspinous_ligament", "ligament", "epidural_lumbar",
                           "subarachnoid_side", "vein", "artery", "bile_duct", "cyst", "bladder",
                           "joint", "bursa", "bone"}) {
    EXPECT_GT(table.TissueIndex(name), 0) << name;
  }
  EXPECT_EQ(table.TissueIndex("no such tissue"), -1);
  EXPECT_LE(table.tissues.size(), static_cast<std::size_t>(kMaxTissues));
  EXPECT_EQ(table.SyringeNamed("lor_glass_10ml").bore_mm, 15.0);
  EXPECT_EQ(table.BoreMm(18, "tuohy"), 1.053);
}

TEST(FluidTable, APatientIsDrawnWithinTheRangesWithTheTypicalAsMedian) {
  const FluidTable typical = ReadFluidTable(kDefaultTable);
  const auto row = static_cast<std::size_t>(typical.TissueIndex("ligament"));
  int below = 0;
  std::set<double> seen;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const FluidTissue drawn = FluidTableFromJson(Default(), "t.json", seed).tissues[row];
    EXPECT_GE(drawn.opening_kpa, 5.0);
    EXPECT_LE(drawn.opening_kpa, 12.0);
    below += drawn.opening_kpa < typical.tissues[row].opening_kpa;
    seen.insert(drawn.opening_kpa);
  }
  EXPECT_NEAR(below, 50, 20);
  EXPECT_GT(seen.size(), 97U);
}

TEST(FluidTable, OneSeedIsOnePatientAndValuesAreDrawnByThemselves) {
  const FluidTable a = ReadFluidTable(kDefaultTable, 3);
  json shorter = Default();
  shorter["tissues"].erase(0);
  const FluidTable b = FluidTableFromJson(shorter, "t.json", 3);
  EXPECT_EQ(a.tissues[static_cast<std::size_t>(a.TissueIndex("bursa"))].opening_kpa,
            b.tissues[static_cast<std::size_t>(b.TissueIndex("bursa"))].opening_kpa);
  const FluidTable c = ReadFluidTable(kDefaultTable, 4);
  EXPECT_NE(a.tissues[1].opening_kpa, c.tissues[1].opening_kpa);
}

TEST(FluidTable, RefusesWhatItCannotMean) {
  json document = Default();
  document["tissues"][1]["opening_kpa"] = {3, 2, 4};
  EXPECT_EQ(ErrorOf(document),
            "t.json: /tissues/1/opening_kpa: is [3,2,4]; give [lowest, typical, highest] in rising "
            "order");
  document = Default();
  document["tissues"][2]["tissue"] = "skin";
  EXPECT_NE(ErrorOf(document).find("/tissues/2/tissue: 'skin' has a row already"),
            std::string::npos);
  document = Default();
  document["tissues"][0]["entry_kpa_s_per_ml"] = {0, 0, 0};
  EXPECT_NE(ErrorOf(document).find("must be above 0"), std::string::npos);
  document = Default();
  document["tissues"][0]["returns"] = "content";
  EXPECT_NE(ErrorOf(document).find("content_ml"), std::string::npos);
  document = Default();
  document["syringes"][0]["static_friction_n"] = 0.1;
  EXPECT_NE(ErrorOf(document).find("sliding_friction_n"), std::string::npos);
  document = Default();
  document["tissues"][0]["pressure"] = 3;
  EXPECT_NE(ErrorOf(document).find("pressure"), std::string::npos);
}

TEST(FluidTable, NamesWhatThereIs) {
  const FluidTable table = ReadFluidTable(kDefaultTable);
  EXPECT_THROW(table.SyringeNamed("bucket"), InputError);
  EXPECT_THROW(table.BoreMm(40, "spinal"), InputError);
}

}  // namespace
}  // namespace acus::fluid
