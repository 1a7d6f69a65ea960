// Hard cases of the image, for every model: nothing may crash, hang or depend on threads or on what
// was drawn before, and each image has a bound that it keeps.
#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <limits>

#include "acus/base/core/error.h"
#include "acus/data/volume/labels.h"
#include "acus/imaging/ultrasound/columns/alamilla.h"
#include "acus/imaging/ultrasound/columns/bmode.h"
#include "acus/imaging/ultrasound/columns/vidal.h"
#include "support/allocation_counter.h"
#include "support/beam_targets.h"
#include "support/bound.h"
#include "support/instruction_sets.h"

namespace acus::ultrasound {
namespace {

namespace fs = std::filesystem;
using testing_support::Above;
using testing_support::AtMost;
using testing_support::Below;
using testing_support::Exactly;
using testing_support::HardCase;
using testing_support::Largest;

/// The same body as CT and as labels.
struct UltrasoundHardCasesBody {
  volume::CtVolume ct;
  volume::LabelMap labels;
};

/// `tissue` by place, mm; -1 at air.
template <typename TissueAt>
UltrasoundHardCasesBody MakeBody(const TissueAt& tissue_at) {
  UltrasoundHardCasesBody body;
  volume::Geometry geometry;
  geometry.size = {64, 72, 48};
  geometry.origin_mm.setConstant(0.5);
  body.ct = volume::CtVolume(geometry, std::int16_t{-1000});
  body.labels = volume::LabelMap(geometry);
  for (int k = 0; k < 48; ++k) {
    for (int j = 0; j < 72; ++j) {
      for (int i = 0; i < 64; ++i) {
        const std::string_view tissue = tissue_at(i + 0.5, j + 0.5, k + 0.5);
        const double hu = tissue == "bone"     ? 1200.0
                          : tissue == "muscle" ? 55.0 + (i * 7 + j * 11 + k * 5) % 13
                                               : -1000.0;
        body.ct.At(i, j, k) = static_cast<std::int16_t>(hu);
        body.labels.At(i, j, k) = tissue == "outside" ? volume::Label{0} : volume::LabelOf(tissue);
      }
    }
  }
  for (const auto& label : volume::StandardLabels()) {
    body.labels.names[label.label] = std::string(label.name);
  }
  return body;
}

/// Muscle from y = 5 mm on, under air.
std::string_view Muscle(double, double y, double) {
  return y > 5.0 ? "muscle" : "outside";
}

acoustics::Probe SmallProbe(acoustics::ProbeKind kind = acoustics::ProbeKind::kLinear) {
  acoustics::Probe probe = testing_support::TargetProbe();
  probe.kind = kind;
  probe.width_mm = 30.0;
  probe.scan_lines = 96;
  probe.samples_per_line = 320;
  probe.image_width_px = 160;
  probe.image_height_px = 200;
  probe.slice_thickness_mm = 3.0;
  probe.pulse_length_mm = 0.7;
  probe.beam_width_mm = 1.2;
  probe.gain_db = 20.0;
  if (kind != acoustics::ProbeKind::kLinear) probe.field_of_view_rad = 1.0;
  if (kind == acoustics::ProbeKind::kCurvilinear) probe.radius_mm = 40.0;
  return probe;
}

fs::path Acoustics(const char* name) {
  return fs::path(ACUS_SOURCE_DIR) / "configs/acoustics" / name;
}

using Render =
    std::function<void(const Eigen::Isometry3d&, const std::optional<image::NeedleInImage>&,
                       image::GrayImage&, int, const slicing::RestMap*)>;

struct Model {
  const char* name;
  std::function<Render(const UltrasoundHardCasesBody&, const acoustics::Probe&)> make;
};

template <typename Renderer>
Render Shared(std::shared_ptr<Renderer> renderer) {
  return
      [renderer](const Eigen::Isometry3d& pose, const std::optional<image::NeedleInImage>& needle,
                 image::GrayImage& out, int threads, const slicing::RestMap* rest) {
        renderer->Render(pose, needle, out, threads, rest);
      };
}

Render MakeBeams(const UltrasoundHardCasesBody& body, acoustics::Probe probe, bool dear) {
  probe.tgc_db_per_cm = 8.0;  // The other models lose nothing in muscle.
  probe.gain_db += 10.0;
  static const acoustics::TissueAcousticsTable table =
      acoustics::ReadTissueAcoustics(Acoustics("tissues.json"));
  BeamOptions options;
  options.elevation_planes = dear ? 3 : 1;
  options.refraction = options.time_of_flight = options.multiple_reflections = dear;
  const BeamTissue tissue{.ct = dear ? nullptr : &body.ct,
                          .labels = dear ? &body.labels : nullptr,
                          .acoustics = &table};
  return Shared(std::make_shared<BeamRenderer>(tissue, probe, options));
}

const std::vector<Model>& Models() {
  static const std::vector<Model> models = {
      {"vidal_2008",
       [](const UltrasoundHardCasesBody& body, const acoustics::Probe& probe) {
         return Shared(std::make_shared<VidalRenderer>(body.ct, probe, DefaultVidalOptions()));
       }},
      {"alamilla_2021",
       [](const UltrasoundHardCasesBody& body, const acoustics::Probe& probe) {
         return Shared(std::make_shared<AlamillaRenderer>(
             body.labels, probe, ReadAlamillaOptions(Acoustics("alamilla_2021.json"))));
       }},
      {"columns_2010",
       [](const UltrasoundHardCasesBody& body, const acoustics::Probe& probe) {
         return Shared(std::make_shared<BModeRenderer>(
             body.ct, probe, ReadBModeOptions(Acoustics("hu_textured.json"))));
       }},
      {"beams on a CT",
       [](const UltrasoundHardCasesBody& body, const acoustics::Probe& probe) {
         return MakeBeams(body, probe, false);
       }},
      {"beams on labels, all effects",
       [](const UltrasoundHardCasesBody& body, const acoustics::Probe& probe) {
         return MakeBeams(body, probe, true);
       }},
  };
  return models;
}

const Eigen::Isometry3d kPose(Eigen::Translation3d(32.0, 4.5, 24.0));

image::NeedleInImage Needle(const Eigen::Vector3d& tip_mm, const Eigen::Vector3d& axis) {
  image::NeedleInImage needle;
  needle.tip_in_ct_mm = tip_mm;
  needle.axis_in_ct = axis.normalized();
  needle.length_mm = 80.0;
  needle.radius_mm = 0.6;
  return needle;
}

image::GrayImage Image(const Render& render, const Eigen::Isometry3d& pose,
                       const std::optional<image::NeedleInImage>& needle = std::nullopt,
                       int threads = 1, const slicing::RestMap* rest = nullptr) {
  image::GrayImage image;
  render(pose, needle, image, threads, rest);
  return image;
}

int Brightest(const image::GrayImage& image) {
  return *std::ranges::max_element(image.pixels);
}

int LargestOf(const image::GrayImage& a, const image::GrayImage& b) {
  int most = 0;
  for (std::size_t n = 0; n < a.pixels.size(); ++n) {
    most = std::max(most, std::abs(a.pixels[n] - b.pixels[n]));
  }
  return most;
}

/// Mean grey of columns [low, high) of some rows.
double MeanGrey(const image::GrayImage& image, int low, int high, int first_row, int end_row) {
  double sum = 0.0;
  for (int r = first_row; r < end_row; ++r) {
    for (int c = low; c < high; ++c) sum += image.At(c, r);
  }
  return sum / ((high - low) * (end_row - first_row));
}

class HardImage : public testing::TestWithParam<int> {
 protected:
  const Model& model() const { return Models()[static_cast<std::size_t>(GetParam())]; }
  std::string Of(const std::string& what) const { return what + ", " + model().name; }
};
INSTANTIATE_TEST_SUITE_P(Models, HardImage, testing::Range(0, 5));

TEST_P(HardImage, PlanesOutsideTheVolumeAreDark) {
  const HardCase hard("The probe's plane beside the volume, up to 1000 km away.");
  Largest grey;
  const UltrasoundHardCasesBody body = MakeBody(Muscle);
  const Render render = model().make(body, SmallProbe(acoustics::ProbeKind::kCurvilinear));
  ASSERT_GT(Brightest(Image(render, kPose)), 40) << model().name;
  for (const double far_mm : {-60.0, -1e3, 1e3, 1e9}) {
    // Beams take what is outside for water, which scatters a little.
    const image::GrayImage image = Image(render, Eigen::Translation3d(0, 0, far_mm) * kPose);
    grey.Add(MeanGrey(image, 0, 160, 0, 200));
  }
  hard.Expect(Of("mean grey"), grey, Below(1.0));
}

TEST_P(HardImage, GrazingPlanesAndFacesAreFinite) {
  const HardCase hard("The plane and the face along edges of the volume and of the skin.");
  Largest air_grey;
  const UltrasoundHardCasesBody body = MakeBody(Muscle);
  for (const acoustics::ProbeKind kind :
       {acoustics::ProbeKind::kLinear, acoustics::ProbeKind::kCurvilinear}) {
    const Render render = model().make(body, SmallProbe(kind));
    for (const double z_mm : {0.0, 0.5, 1e-12, 47.5, 48.0}) {
      Eigen::Isometry3d pose = kPose;
      pose.translation().z() = z_mm;
      EXPECT_EQ(Image(render, pose).pixels.size(), 160U * 200U);
    }
    // The face along the skin, along the volume's edge, and upside down.
    for (const double deg : {45.0, 89.999, 90.0, 180.0}) {
      const Eigen::Isometry3d pose =
          kPose * Eigen::AngleAxisd(deg * std::numbers::pi / 180.0, Eigen::Vector3d::UnitZ());
      const image::GrayImage image = Image(render, pose);
      EXPECT_EQ(image.pixels, Image(render, pose, std::nullopt, 3).pixels) << model().name;
      if (deg == 180.0) {
        air_grey.Add(MeanGrey(image, 0, 160, 60, 200));
      }
    }
  }
  hard.Expect(Of("mean grey of a probe that looks into air"), air_grey, Below(2.0));
}

TEST_P(HardImage, OneVoxelOfBoneIsSeenAndShadows) {
  const HardCase hard("Bone one voxel thick: between two samples it could be missed.");
  const auto with_bone = [](double x, double y, double z) -> std::string_view {
    const bool bone = y > 25.0 && y < 26.0 && x > 26.0 && x < 38.0 && z > 4.0;
    return bone ? "bone" : Muscle(x, y, z);
  };
  const UltrasoundHardCasesBody body = MakeBody(with_bone);
  const UltrasoundHardCasesBody without = MakeBody(Muscle);
  const Render render = model().make(body, SmallProbe());
  const image::GrayImage image = Image(render, kPose);
  const image::GrayImage free = Image(model().make(without, SmallProbe()), kPose);
  const int bone_row = static_cast<int>((25.0 - 4.5) / 40.0 * 199.0);
  int line = 0;
  for (int r = bone_row - 3; r < bone_row + 12; ++r) line = std::max<int>(line, image.At(80, r));
  hard.Expect(Of("grey of the bone above what is there without it"),
              line - MeanGrey(free, 75, 85, bone_row - 3, bone_row + 12), Above(40.0));
  const double shadow = MeanGrey(image, 75, 85, bone_row + 35, 195);
  hard.Expect(Of("grey of the shadow, of that without bone"),
              shadow / MeanGrey(free, 75, 85, bone_row + 35, 195), Below(0.5));
}

TEST_P(HardImage, AllGasIsDark) {
  const HardCase hard("Nothing but gas: its impedance is 1/4000 of water's.");
  const UltrasoundHardCasesBody gas = MakeBody([](double, double, double) { return "gas"; });
  const Render render = model().make(gas, SmallProbe());
  const image::GrayImage image = Image(render, Eigen::Isometry3d(Eigen::Translation3d(32, 10, 24)));
  hard.Expect(Of("mean grey"), MeanGrey(image, 0, 160, 40, 200), Below(20.0));
}

TEST_P(HardImage, NeedlesInThePlaneAndAcrossIt) {
  const HardCase hard(
      "A needle in the plane, across it, along the beam, without length, far away, NaN.");
  const UltrasoundHardCasesBody body = MakeBody(Muscle);
  const Render render = model().make(body, SmallProbe());
  const image::GrayImage bare = Image(render, kPose);
  const Eigen::Vector3d tip_mm(32.0, 25.0, 24.0);
  const image::GrayImage in_plane = Image(render, kPose, Needle(tip_mm, {1.0, 0.3, 0.0}));
  hard.Expect(Of("grey of a needle in the plane"), LargestOf(bare, in_plane), Above(60));
  const image::GrayImage across =
      Image(render, kPose, Needle(tip_mm + Eigen::Vector3d(0, 0, 20), Eigen::Vector3d::UnitZ()));
  hard.Expect(Of("grey of a needle across it"), LargestOf(bare, across), Above(25));
  // Along the beam, without length, without radius, and far away.
  image::NeedleInImage odd = Needle(tip_mm, Eigen::Vector3d::UnitY());
  Image(render, kPose, odd);
  odd.length_mm = 0.0;
  Image(render, kPose, odd);
  odd = Needle(tip_mm, {1.0, 0.2, 0.0});
  odd.radius_mm = 0.0;
  Image(render, kPose, odd);
  const image::GrayImage away = Image(render, kPose, Needle({32.0, 25.0, 1e6}, {1.0, 0.0, 0.0}));
  EXPECT_EQ(away.pixels, bare.pixels) << model().name;
  image::NeedleInImage broken = Needle(tip_mm, {1.0, 0.0, 0.0});
  broken.tip_in_ct_mm.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(Image(render, kPose, broken), InputError) << model().name;
}

TEST_P(HardImage, DepthsFromNothingToHundredMillimetres) {
  const HardCase hard("No depth, 10 degrees, 100 mm of face and depth, 5 mm of depth.");
  int least_bright = 255;
  const UltrasoundHardCasesBody body = MakeBody(Muscle);
  for (const double depth_mm : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    acoustics::Probe probe = SmallProbe();
    probe.depth_mm = depth_mm;
    EXPECT_THROW(model().make(body, probe), InputError) << model().name << " " << depth_mm;
  }
  // 10 degrees, and 100 mm of face and depth: more than the body.
  acoustics::Probe narrow = SmallProbe(acoustics::ProbeKind::kCurvilinear);
  narrow.field_of_view_rad = 10.0 * std::numbers::pi / 180.0;
  acoustics::Probe wide = SmallProbe();
  wide.width_mm = wide.depth_mm = 100.0;
  acoustics::Probe shallow = SmallProbe();
  shallow.depth_mm = 5.0;
  shallow.width_mm = 10.0;
  shallow.pulse_length_mm = 0.2;
  shallow.beam_width_mm = 0.4;
  for (const acoustics::Probe& probe : {narrow, wide, shallow}) {
    const Render render = model().make(body, probe);
    const image::GrayImage image = Image(render, kPose, Needle({32, 20, 24}, {1.0, 0.4, 0.1}));
    least_bright = std::min(least_bright, Brightest(image));
    EXPECT_EQ(image.pixels, Image(render, kPose, Needle({32, 20, 24}, {1.0, 0.4, 0.1}), 2).pixels);
  }
  hard.Expect(Of("brightest pixel of the darkest"), least_bright, Above(20));
}

class Press : public slicing::RestMap {
 public:
  Eigen::Vector3d RestInCtMm(const Eigen::Vector3d& place_mm,
                             const Eigen::Vector3d&) const noexcept override {
    const double far = (place_mm - Eigen::Vector3d(32, 20, 24)).squaredNorm();
    return place_mm - Eigen::Vector3d(0.3, 1.5, 0.2) * std::exp(-far / 150.0);
  }
  double SpacingMm() const noexcept override { return 3.0; }
};

TEST_P(HardImage, BitsDoNotDependOnThreadsAndNothingIsAllocated) {
  const HardCase hard(
      "1, 2, 3 and 8 threads share an image: sums in another order have other bits.");
  int num_differ = 0;
  long allocated = 0;
  const UltrasoundHardCasesBody body = MakeBody(Muscle);
  const Press press;
  const image::NeedleInImage needle = Needle({32, 25, 24}, {1.0, 0.3, 0.05});
  for (const acoustics::ProbeKind kind :
       {acoustics::ProbeKind::kLinear, acoustics::ProbeKind::kCurvilinear}) {
    const Render render = model().make(body, SmallProbe(kind));
    const image::GrayImage one = Image(render, kPose, needle, 1, &press);
    for (const int threads : {2, 3, 8}) {
      const image::GrayImage other = Image(render, kPose, needle, threads, &press);
      num_differ += one.pixels == other.pixels ? 0 : 1;
    }
    for (const int threads : {1, 2}) {
      image::GrayImage image;
      render(kPose, needle, image, threads, &press);
      const long before = testing_support::num_allocations;
      for (int n = 0; n < 5; ++n) {
        render(Eigen::Translation3d(0.1 * n, 0, 0) * kPose, needle, image, threads, &press);
      }
      allocated += testing_support::num_allocations - before;
    }
  }
  hard.Expect(Of("images that differ by the number of threads"), num_differ, Exactly(0));
  hard.Expect(Of("allocations in an image"), allocated, Exactly(0));
}

TEST_P(HardImage, EveryInstructionSetGivesTheSameBits) {
  const HardCase hard("Vectors of 128 to 512 bits, with fused multiply-add and without.");
  Largest off;
  const UltrasoundHardCasesBody body = MakeBody(Muscle);
  const Press press;
  const image::NeedleInImage needle = Needle({32, 25, 24}, {1.0, 0.3, 0.05});
  const Render render = model().make(body, SmallProbe(acoustics::ProbeKind::kCurvilinear));
  const image::GrayImage best = Image(render, kPose, needle, 1, &press);
  testing_support::OnEveryInstructionSet(
      [&](const char*) { off.Add(LargestOf(best, Image(render, kPose, needle, 1, &press))); });
  hard.Expect(Of("difference in grey levels"), off, Exactly(0));
}

}  // namespace
}  // namespace acus::ultrasound
