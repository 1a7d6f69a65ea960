#include "acus/imaging/acoustics/tissue_acoustics.h"

#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/data/volume/labels.h"
#include "support/fuzz.h"
#include "support/temporary_folder.h"

namespace acus::acoustics {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

const std::filesystem::path kPreset =
    std::filesystem::path(ACUS_SOURCE_DIR) / "configs/acoustics/tissues.json";

TEST(TissueAcoustics, ThePresetHasARowForEveryStandardLabel) {
  const TissueAcousticsTable table = ReadTissueAcoustics(kPreset);
  for (const volume::StandardLabel& label : volume::StandardLabels()) {
    EXPECT_TRUE(table.tissues.contains(std::string(label.name))) << label.name;
  }
}

TEST(TissueAcoustics, EveryValueOfThePresetNamesItsSource) {
  const auto document = config::ReadJson(kPreset);
  for (const auto& [name, row] : document.at("tissues").items()) {
    for (const auto& [key, value] : row.items()) {
      if (key == "sources") continue;
      EXPECT_TRUE(row.at("sources").contains(key)) << name << "/" << key;
    }
  }
}

TEST(TissueAcoustics, ThePresetHoldsTheMeasuredValues) {
  const TissueAcousticsTable table = ReadTissueAcoustics(kPreset);
  EXPECT_EQ(table.Of("fat").speed_m_per_s, 1450.0);
  EXPECT_EQ(table.Of("liver").impedance_mrayl, 1.65);
  EXPECT_EQ(table.Of("bone").speed_m_per_s, 4080.0);
  // Along to across the fibres of muscle: 1.40 to 0.96 dB/cm at 1 MHz.
  const TissueAcoustics& muscle = table.Of("muscle");
  EXPECT_DOUBLE_EQ(muscle.AttenuationDbPerCm(1.0, 0.0), 0.96);
  EXPECT_DOUBLE_EQ(muscle.AttenuationDbPerCm(1.0, 1.0), 1.40);
  EXPECT_DOUBLE_EQ(muscle.AttenuationDbPerCm(5.0, -1.0), 5 * 1.40);
  EXPECT_DOUBLE_EQ(table.Of("water").AttenuationDbPerCm(10.0), 100 * 0.0022);
  // No tissue is fluid in its echo and solid in its name: fluids are darker than all tissues.
  for (const char* fluid : {"blood", "bladder", "gallbladder", "bursa", "spinal_canal"}) {
    EXPECT_LT(table.Of(fluid).backscatter_db, table.Of("kidney").backscatter_db - 15) << fluid;
  }
}

TEST(TissueAcoustics, BetweenKnotsOfHuAllValuesAreLinear) {
  TissueAcousticsTable table;
  table.file = "t.json";
  table.tissues["a"] = {.speed_m_per_s = 1000, .impedance_mrayl = 1, .backscatter_db = -50};
  table.tissues["b"] = {.speed_m_per_s = 2000, .impedance_mrayl = 3, .backscatter_db = -40};
  table.by_hu = {{0, "a"}, {100, "b"}};
  EXPECT_EQ(table.AtHu(-500).speed_m_per_s, 1000);
  EXPECT_EQ(table.AtHu(0).speed_m_per_s, 1000);
  EXPECT_EQ(table.AtHu(100).speed_m_per_s, 2000);
  EXPECT_EQ(table.AtHu(3000).impedance_mrayl, 3);
  EXPECT_DOUBLE_EQ(table.AtHu(25).speed_m_per_s, 1250);
  EXPECT_DOUBLE_EQ(table.AtHu(25).impedance_mrayl, 1.5);
  EXPECT_DOUBLE_EQ(table.AtHu(25).backscatter_db, -47.5);
}

TEST(TissueAcoustics, AnUnknownTissueNamesTheNearest) {
  const TissueAcousticsTable table = ReadTissueAcoustics(kPreset);
  EXPECT_THAT([&] { table.Of("livr"); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("tissues.json"), HasSubstr("'liver'"))));
}

volume::LabelMap Labels(std::initializer_list<volume::Label> values) {
  volume::LabelMap labels(
      volume::Geometry{.size = {static_cast<int>(values.size()), 1, 1}, .spacing_mm = {1, 1, 1}});
  std::ranges::copy(values, labels.voxels.begin());
  return labels;
}

TEST(TissueAcoustics, LabelsGoByTheirNameInTheMapElseByTheStandardName) {
  const TissueAcousticsTable table = ReadTissueAcoustics(kPreset);
  volume::LabelMap labels = Labels({0, 1, 8, 2, 77});
  labels.names[77] = "tendon";
  labels.names[2] = "muscle";  // This map's 2 is not the standard's.
  const LabelAcoustics dense = AcousticsOfLabels(table, labels, "labels.nrrd");
  EXPECT_EQ(dense.of[1].impedance_mrayl,
            table.Of(volume::StandardLabels()[1].name).impedance_mrayl);
  EXPECT_EQ(dense.of[8].impedance_mrayl, table.Of("liver").impedance_mrayl);
  EXPECT_EQ(dense.of[2].impedance_mrayl, table.Of("muscle").impedance_mrayl);
  EXPECT_EQ(dense.of[77].fibre_ratio, table.Of("tendon").fibre_ratio);
  EXPECT_EQ(dense.of[0].speed_m_per_s, table.Of("outside").speed_m_per_s);
  EXPECT_TRUE(dense.occurs.test(77));
  EXPECT_FALSE(dense.occurs.test(3));
}

TEST(TissueAcoustics, ALabelWithoutARowSaysWhichAndWhatToDo) {
  TissueAcousticsTable table = ReadTissueAcoustics(kPreset);
  table.tissues.erase("liver");
  EXPECT_THAT(
      [&] {
        AcousticsOfLabels(table, Labels({0, 8}), "labels.nrrd");
      },
      ThrowsMessage<InputError>(AllOf(HasSubstr("labels.nrrd"), HasSubstr("label 8"),
                                      HasSubstr("\"liver\""), HasSubstr("tissues.json"),
                                      HasSubstr("add \"liver\""))));
  EXPECT_THAT([&] { AcousticsOfLabels(table, Labels({200}), "labels.nrrd"); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("label 200"), HasSubstr("no name"))));
  EXPECT_NO_THROW(AcousticsOfLabels(table, Labels({0, 9}), "labels.nrrd"));
}

class TissueAcousticsFile : public ::testing::Test {
 protected:
  void Refuses(const char* pointer, const nlohmann::json& value, const char* message) {
    auto document = config::ReadJson(kPreset);
    document[nlohmann::json::json_pointer(pointer)] = value;
    const auto path = folder_ / "t.json";
    config::WriteJson(path, document);
    EXPECT_THAT([&] { ReadTissueAcoustics(path); }, ThrowsMessage<InputError>(HasSubstr(message)))
        << pointer;
  }
  testing_support::TemporaryFolder folder_;
};

TEST_F(TissueAcousticsFile, ValuesOutOfRangeAreRefused) {
  Refuses("/tissues/liver/speed_m_per_s", 99, "/tissues/liver/speed_m_per_s");
  Refuses("/tissues/liver/speed_m_per_s", 10001, "/tissues/liver/speed_m_per_s");
  Refuses("/tissues/liver/impedance_mrayl", 0, "/tissues/liver/impedance_mrayl");
  Refuses("/tissues/liver/impedance_mrayl", 201, "/tissues/liver/impedance_mrayl");
  Refuses("/tissues/fat/attenuation_db_per_cm_mhz", -0.1, "attenuation_db_per_cm_mhz");
  Refuses("/tissues/fat/attenuation_db_per_cm_mhz", 201, "attenuation_db_per_cm_mhz");
  Refuses("/tissues/fat/attenuation_exponent", 3.1, "attenuation_exponent");
  Refuses("/tissues/fat/attenuation_exponent", -0.1, "attenuation_exponent");
  Refuses("/tissues/fat/backscatter_db", 1, "backscatter_db");
  Refuses("/tissues/fat/backscatter_db", -201, "backscatter_db");
  Refuses("/tissues/fat/fibre_ratio", 0.9, "fibre_ratio");
  Refuses("/tissues/fat/fibre_ratio", 21, "fibre_ratio");
  Refuses("/tissues/fat/scatterers_per_mm3", -1, "scatterers_per_mm3");
  Refuses("/tissues/fat/scatterers_per_mm3", 2e5, "scatterers_per_mm3");
  Refuses("/tissues/fat/speed", 1500, "speed");
}

TEST_F(TissueAcousticsFile, WrongReferencesWithinTheFileAreRefused) {
  Refuses("/tissues/fat/sources/speed_m_per_s", "nowhere", "not listed in /references");
  Refuses("/tissues/fat/sources/attenuation_along_fibres_db_per_cm_mhz", "estimate",
          "not a value of this tissue");
  Refuses("/by_hu/2/tissue", "fatt", "'fat'");
  Refuses("/by_hu/1/hu", -1000, "sort the knots");
  Refuses("/by_hu", nlohmann::json::array(), "/by_hu");
}

TEST_F(TissueAcousticsFile, DamagedFilesAreReadOrRefused) {
  const std::string valid = ReadTextFile(kPreset);
  const auto path = folder_ / "damaged.json";
  const auto read = [&] { ReadTissueAcoustics(path); };
  EXPECT_GT(testing_support::ReadDamagedCopies(valid, path, 200, read), 50);
}

}  // namespace
}  // namespace acus::acoustics
