#include "acus/imaging/acoustics/plus_simulator.h"

#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numbers>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "support/fuzz.h"
#include "support/temporary_folder.h"

namespace acus::acoustics {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr const char* kLinear = R"(<ScanConversion TransducerName="L9-4" TransducerGeometry="LINEAR"
  ImagingDepthMm="50.0" TransducerWidthMm="40.0" OutputImageSizePixel="820 616"
  TransducerCenterPixel="410 0" OutputImageSpacingMmPerPixel="0.084 0.087"/>)";
constexpr const char* kCurved = R"(<ScanConversion TransducerName="C5-2"
  TransducerGeometry="CURVILINEAR" RadiusStartMm="60.0" RadiusStopMm="120.0" ThetaStartDeg="-28.0"
  ThetaStopDeg="28.0" TransducerCenterPixel="410 100" OutputImageSizePixel="820 616"
  OutputImageSpacingMmPerPixel="0.12 0.15" />)";

std::string Document(const std::string& scan) {
  return R"(<PlusConfiguration version="2.3"><DataCollection><Device Type="UsSimulator">
    <vtkPlusUsSimulatorAlgo FrequencyMhz="4" NumberOfScanlines="128"
                            NumberOfSamplesPerScanline="1000">
      <SpatialModel Name="Air" DensityKgPerM3="1.2" SoundVelocityMPerSec="343"
        AttenuationCoefficientDbPerCmMhz="100.0" BackscatterDiffuseReflectionCoefficient="0.1"/>
      <SpatialModel Name="GelBlock" ObjectCoordinateFrame="Reference" ModelFile="gel.stl"
        DensityKgPerM3="910" SoundVelocityMPerSec="1540" AttenuationCoefficientDbPerCmMhz="3.0"
        BackscatterDiffuseReflectionCoefficient="0.1"/>
      <SpatialModel Name="Liver" ObjectCoordinateFrame="Reference" ModelFile="liver.stl"
        ModelToObjectTransform=" 1 0 0 5
          0 1 0 0  0 0 1 0  0 0 0 1"
        DensityKgPerM3="1060" SoundVelocityMPerSec="1550" AttenuationCoefficientDbPerCmMhz="0.5"
        />
      <RfProcessing>)" +
         scan + R"(</RfProcessing></vtkPlusUsSimulatorAlgo></Device></DataCollection>
  </PlusConfiguration>)";
}

class PlusSimulatorFile : public ::testing::Test {
 protected:
  std::filesystem::path Write(const std::string& text) {
    WriteTextFile(path_, text);
    return path_;
  }
  void Refuses(std::string text, const char* from, const char* to, const char* message) {
    const auto at = text.find(from);
    ASSERT_NE(at, text.npos) << from;
    text.replace(at, std::string(from).size(), to);
    Write(text);
    EXPECT_THAT([&] { ReadPlusSimulator(path_); },
                ThrowsMessage<InputError>(AllOf(HasSubstr("plus.xml"), HasSubstr(message))))
        << from << " -> " << to;
  }
  testing_support::TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "plus.xml";
};

TEST_F(PlusSimulatorFile, ALinearProbeIsUsableWhereAPresetIs) {
  const Probe probe = ReadProbe(Write(Document(kLinear)));
  EXPECT_EQ(probe.name, "L9-4");
  EXPECT_EQ(probe.kind, ProbeKind::kLinear);
  EXPECT_EQ(probe.width_mm, 40.0);
  EXPECT_EQ(probe.depth_mm, 50.0);
  EXPECT_EQ(probe.frequency_mhz, 4.0);
  EXPECT_EQ(probe.scan_lines, 128);
  EXPECT_EQ(probe.samples_per_line, 1000);
  const image::ImageGeometry image = ImageOf(probe);
  EXPECT_EQ(image.width_px, 820);
  EXPECT_EQ(image.height_px, 616);
  EXPECT_EQ(image.lateral_mm_per_px, 0.084);
  EXPECT_EQ(image.axial_mm_per_px, 0.087);
  const ScanGrid grid = ScanGridOf(probe);
  EXPECT_EQ(grid.lines(), 476);  // 40 mm / 0.084 mm.
  EXPECT_EQ(grid.samples, 575);  // 50 mm / 0.087 mm, and the face.
}

TEST_F(PlusSimulatorFile, ACurvedProbeKeepsTheImageOfPlus) {
  const Probe probe = ReadProbe(Write(Document(kCurved)));
  EXPECT_EQ(probe.kind, ProbeKind::kCurvilinear);
  EXPECT_EQ(probe.radius_mm, 60.0);
  EXPECT_EQ(probe.depth_mm, 60.0);
  EXPECT_NEAR(probe.field_of_view_rad, 56.0 * std::numbers::pi / 180.0, 1e-12);
  // Row 100 is at the face.
  const Eigen::Vector3d face = ImageOf(probe).probe_from_image() * Eigen::Vector3d(409.5, 100, 0);
  EXPECT_NEAR(face.norm(), 0.0, 1e-9);
}

TEST_F(PlusSimulatorFile, SpatialModelsBecomeTissues) {
  const TissueAcousticsTable table = ReadTissueAcoustics(Write(Document(kLinear)));
  EXPECT_EQ(table.tissues.size(), 4u);  // Three, and "outside".
  EXPECT_NEAR(table.Of("gelblock").impedance_mrayl, 910 * 1540e-6, 1e-12);
  EXPECT_EQ(table.Of("gelblock").attenuation_db_per_cm_mhz, 3.0);
  EXPECT_EQ(table.Of("outside").speed_m_per_s, 343.0);
  EXPECT_EQ(table.AtHu(40).speed_m_per_s, 343.0);
  // Lost per mm: 3 dB/cm/MHz at 4 MHz = 1.2 dB/mm, of which a tenth comes back.
  EXPECT_NEAR(table.Of("gelblock").backscatter_db, 10 * std::log10(0.1 * 1.2 * 0.230259), 1e-4);
  EXPECT_EQ(table.Of("liver").scatterers_per_mm3, 0.0);
}

TEST_F(PlusSimulatorFile, SurfacesGetTheStandardLabelOfTheirName) {
  const PlusSimulator plus = ReadPlusSimulator(Write(Document(kLinear)));
  ASSERT_EQ(plus.surfaces.size(), 2u);
  EXPECT_EQ(plus.surfaces[0].label, 129);
  EXPECT_EQ(plus.surfaces[0].file, "gel.stl");
  EXPECT_EQ(plus.surfaces[1].label, 8);
  EXPECT_EQ(plus.surfaces[1].object_from_model(0, 3), 5.0);
}

TEST_F(PlusSimulatorFile, WrongValuesAreNamed) {
  const std::string linear = Document(kLinear);
  const std::string curved = Document(kCurved);
  Refuses(linear, "ImagingDepthMm=\"50.0\"", "ImagingDepthMm=\"0\"", "ImagingDepthMm");
  Refuses(linear, "ImagingDepthMm=\"50.0\"", "", "has no ImagingDepthMm");
  Refuses(linear, "TransducerWidthMm=\"40.0\"", "TransducerWidthMm=\"x\"", "TransducerWidthMm");
  Refuses(linear, "\"LINEAR\"", "\"SECTOR\"", "LINEAR, CURVILINEAR");
  Refuses(linear, "820 616", "820", "give 2 numbers");
  Refuses(linear, "820 616", "8200 616", "OutputImageSizePixel");
  Refuses(linear, "410 0", "300 0", "give 410");
  Refuses(linear, "410 0", "410 700", "must be in the image");
  Refuses(linear, "0.084 0.087", "0.084 -1", "OutputImageSpacingMmPerPixel");
  Refuses(linear, "FrequencyMhz=\"4\"", "FrequencyMhz=\"400\"", "FrequencyMhz");
  Refuses(linear, "DensityKgPerM3=\"910\"", "DensityKgPerM3=\"nan\"", "DensityKgPerM3");
  Refuses(linear, "SoundVelocityMPerSec=\"1540\"", "", "has no SoundVelocityMPerSec");
  Refuses(linear, "Name=\"GelBlock\"", "Name=\"air\"", "rename one");
  Refuses(linear, "Name=\"GelBlock\"", "", "has no Name");
  Refuses(linear, "0 1 0 0", "0 1 0", "ModelToObjectTransform");
  Refuses(curved, "ThetaStopDeg=\"28.0\"", "ThetaStopDeg=\"20\"", "the same to both sides");
  Refuses(curved, "RadiusStopMm=\"120.0\"", "RadiusStopMm=\"60\"", "5 to 300 mm");
  Refuses(linear, "<ScanConversion", "<xScanConversion", "has no ScanConversion");
}

TEST_F(PlusSimulatorFile, ASmallAndALargeRadiusAreRead) {
  for (const auto& [start, stop] : {std::pair{"1", "61"}, {"200", "260"}}) {
    std::string text = Document(kCurved);
    text.replace(text.find("60.0"), 4, start);
    text.replace(text.find("120.0"), 5, stop);
    const Probe probe = ReadProbe(Write(text));
    EXPECT_EQ(probe.radius_mm, std::stod(start));
    EXPECT_EQ(probe.depth_mm, 60.0);
  }
  Refuses(Document(kCurved), "RadiusStartMm=\"60.0\"", "RadiusStartMm=\"0.9\"", "1 to 200");
  Refuses(Document(kCurved), "RadiusStartMm=\"60.0\"", "RadiusStartMm=\"200.1\"", "1 to 200");
}

TEST_F(PlusSimulatorFile, OtherXmlIsRefused) {
  EXPECT_THAT([&] { ReadProbe(Write("<MRML/>")); },
              ThrowsMessage<InputError>(HasSubstr("not a PLUS configuration")));
  const std::string none = "<PlusConfiguration>" + std::string(kLinear) + "</PlusConfiguration>";
  EXPECT_NO_THROW(ReadProbe(Write(none)));
  EXPECT_THAT([&] { ReadTissueAcoustics(Write(none)); },
              ThrowsMessage<InputError>(HasSubstr("no SpatialModel")));
}

TEST_F(PlusSimulatorFile, DamagedFilesAreReadOrRefused) {
  const auto read = [&] { ReadPlusSimulator(path_); };
  for (const char* scan : {kLinear, kCurved}) {
    EXPECT_GT(testing_support::ReadDamagedCopies(Document(scan), path_, 400, read), 50);
  }
}

}  // namespace
}  // namespace acus::acoustics
