#include "acus/imaging/ultrasound/columns/bmode_options.h"

#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "support/fuzz.h"
#include "support/temporary_folder.h"

namespace acus::ultrasound {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Reads options in which one key has the given value.
BModeOptions With(const std::string& key, const json& value) {
  const testing_support::TemporaryFolder folder;
  const fs::path path = folder / "acoustics.json";
  WriteTextFile(path, json{{"format", "acus-acoustics/1"}, {key, value}}.dump());
  return ReadBModeOptions(path);
}

TEST(BModeOptions, DefaultsAreThoseOf2010) {
  const BModeOptions options = DefaultBModeOptions();
  EXPECT_FALSE(options.attenuation);
  EXPECT_FALSE(options.texture);
  EXPECT_EQ(options.angle_exponent, 0);
  EXPECT_EQ(options.needle_reflection, options.boosted_reflection);
  const BModeOptions preset =
      ReadBModeOptions(fs::path(ACUS_SOURCE_DIR) / "configs/acoustics/hu_2010.json");
  EXPECT_EQ(preset.name, options.name);
  EXPECT_EQ(preset.shadow_threshold, options.shadow_threshold);
}

TEST(BModeOptions, BothEndsOfEveryRangeAreGuarded) {
  const struct {
    const char* key;
    json good_low, good_high, bad_low, bad_high;
  } ranges[] = {{"interface_span_mm", 0, 5, -0.1, 5.1},
                {"shadow_threshold", 1e-9, 1, 0, 1.1},
                {"boosted_reflection", 0.1, 1, 0.09, 1.01},
                {"needle_reflection", 0.1, 1, 0.09, 1.01},
                {"angle_exponent", 0, 2, -1, 3},
                {"texture_grain_mm", 0.05, 5, 0.04, 5.1},
                {"coupling_gap_mm", 0, 50, -1, 51}};
  for (const auto& range : ranges) {
    EXPECT_NO_THROW(With(range.key, range.good_low)) << range.key;
    EXPECT_NO_THROW(With(range.key, range.good_high)) << range.key;
    EXPECT_THROW(With(range.key, range.bad_low), InputError) << range.key;
    EXPECT_THROW(With(range.key, range.bad_high), InputError) << range.key;
  }
}

TEST(BModeOptions, CurvesMustBeSortedAndPhysical) {
  const auto curve = [](double hu0, double v0, double hu1, double v1) {
    return json::array({{{"hu", hu0}, {"value", v0}}, {{"hu", hu1}, {"value", v1}}});
  };
  EXPECT_NO_THROW(With("impedance_mrayl", curve(-1000, 0.0004, 0, 1.5)));
  EXPECT_THROW(With("impedance_mrayl", curve(0, 1.5, -1000, 0.0004)), InputError);
  EXPECT_THROW(With("impedance_mrayl", curve(0, 1.5, 0, 1.6)), InputError);
  EXPECT_THROW(With("impedance_mrayl", curve(-1000, 0, 0, 1.5)), InputError);
  EXPECT_THROW(With("impedance_mrayl", json::array()), InputError);
  EXPECT_THROW(With("attenuation_db_per_cm_mhz", curve(0, -0.1, 50, 0.7)), InputError);
  EXPECT_NO_THROW(With("attenuation_db_per_cm_mhz", curve(0, 0, 50, 0.7)));
}

TEST(BModeOptions, DamagedFilesAreReadOrRefused) {
  const json curve =
      json::array({{{"hu", -1000}, {"value", 0.0004}}, {{"hu", 4000}, {"value", 7.5}}});
  const std::string valid = json{
      {"format", "acus-acoustics/1"},
      {"name", "x"},
      {"impedance_mrayl", curve},
      {"texture", true}}.dump(2);
  const testing_support::TemporaryFolder folder;
  const fs::path path = folder / "damaged.json";
  EXPECT_GT(testing_support::ReadDamagedCopies(valid, path, 200, [&] { ReadBModeOptions(path); }),
            50);
}

}  // namespace
}  // namespace acus::ultrasound
