// Signs by which sonographers recognise organs, bones and needles, measured on images of phantoms.
// docs/models/ultrasound_signs.md has the same table; a test compares both.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <sstream>
#include <vector>

#include "acus/imaging/ultrasound/aperture/aperture_renderer.h"
#include "support/beam_targets.h"

namespace acus::ultrasound {
namespace {

namespace fs = std::filesystem;
const fs::path kRoot = ACUS_SOURCE_DIR;

/// Middle of the face in the phantoms, mm: the sides of a curved face lie 8 mm higher.
constexpr double kFaceX = 80.0;
constexpr double kFaceY = 10.0;
constexpr double kFaceZ = 30.0;

const std::map<volume::Label, std::string> kNames = {
    {1, "soft_tissue"}, {2, "fat"},      {3, "muscle"},    {4, "liver"},        {5, "kidney"},
    {6, "spleen"},      {7, "pancreas"}, {8, "vessel"},    {9, "gallbladder"},  {10, "bone"},
    {11, "lung"},       {12, "gas"},     {13, "ligament"}, {14, "spinal_canal"}};
volume::Label Of(const std::string& name) {
  for (const auto& [label, of] : kNames) {
    if (of == name) return label;
  }
  ADD_FAILURE() << name;
  return 0;
}

/// x along the face from its middle, z across the image plane, depth below the middle of the face.
using LabelAt = std::function<volume::Label(double x, double depth, double z)>;

/// An image of a phantom with the probe and the settings of the presets.
class Picture {
 public:
  explicit Picture(const LabelAt& label_at, const std::optional<image::NeedleInImage>& needle = {},
                   const Eigen::Array3d& spacing_mm = {1.0, 1.0, 1.0})
      : labels_(Block(label_at, spacing_mm)),
        table_(acoustics::ReadTissueAcoustics(kRoot / "configs/acoustics/tissues.json")),
        probe_(acoustics::ReadProbe(kRoot / "configs/probes/curvilinear_c5_2.json")) {
    ApertureOptions options;
    options.fibre_texture = options.organ_structure = true;
    tgc_limit_db_ = options.tgc_limit_db;
    BeamTissue tissue{.labels = &labels_, .acoustics = &table_};
    tissue.fibres_in_ct["muscle"] = {1.0, 0.0, 0.2};
    ApertureRenderer renderer(tissue, probe_, options);
    std::optional<image::NeedleInImage> in_ct = needle;
    const Eigen::Vector3d face(kFaceX, kFaceY, kFaceZ);
    if (in_ct) in_ct->tip_in_ct_mm += face;
    renderer.Render(testing_support::FaceAt(kFaceX, kFaceY, kFaceZ), in_ct, image_);
    geometry_ = renderer.image();
    const slicing::BeamImage& envelope = renderer.envelope();
    grid_ = renderer.grid();
    for (int k = 0; k < grid_.samples; ++k) {
      rows_.emplace_back(envelope.row(k), envelope.row(k) + grid_.lines());
    }
  }

  /// Level on the screen, dB, before it is cut off: with gain and TGC; mean intensity over a patch.
  double Level(double x, double depth, double half_x = 6.0, double half_depth = 2.0) const {
    double sum = 0.0;
    int count = 0;
    Visit(x, depth, half_x, half_depth, [&](double level, double, double) {
      sum += std::pow(10.0, 0.1 * level);
      ++count;
    });
    return 10.0 * std::log10(sum / count);
  }
  /// Largest level of a patch, and its depth.
  double Peak(double x, double depth, double half_x, double half_depth,
              double* at_depth = nullptr) const {
    double most = -1e9;
    Visit(x, depth, half_x, half_depth, [&](double level, double, double at) {
      if (level <= most) return;
      most = level;
      if (at_depth != nullptr) *at_depth = at;
    });
    return most;
  }
  /// Envelope: mean over standard deviation.
  double SpeckleSnr(double x, double depth, double half) const {
    double sum = 0.0;
    double sum2 = 0.0;
    int count = 0;
    Visit(x, depth, half, half, [&](double level, double, double at) {
      // Attenuation and TGC within the patch do not count.
      const double a = std::pow(10.0, 0.05 * (level - slope_db_per_mm_ * (at - depth)));
      sum += a;
      sum2 += a * a;
      ++count;
    });
    const double mean = sum / count;
    return mean / std::sqrt(sum2 / count - mean * mean);
  }
  void RemoveSlope(double db_per_mm) { slope_db_per_mm_ = db_per_mm; }

  double Grey(double x, double depth, double half_x = 6.0, double half_depth = 2.0) const {
    double sum = 0.0;
    int count = 0;
    VisitPixels(x, depth, half_x, half_depth, [&](int grey) {
      sum += grey;
      ++count;
    });
    return sum / count;
  }
  /// Standard deviation of the grey of squares of 2 mm.
  double Structure(double depth, double half_x, double half_depth) const {
    double sum = 0.0;
    double sum2 = 0.0;
    int count = 0;
    for (double x = -half_x; x < half_x; x += 2.0) {
      for (double d = depth - half_depth; d < depth + half_depth; d += 2.0) {
        const double grey = Grey(x, d, 1.0, 1.0);
        sum += grey;
        sum2 += grey * grey;
        ++count;
      }
    }
    return std::sqrt(sum2 / count - sum * sum / count / count);
  }

 private:
  static volume::LabelMap Block(const LabelAt& label_at, const Eigen::Array3d& spacing_mm) {
    volume::Geometry geometry;
    geometry.spacing_mm = spacing_mm;
    geometry.size = (Eigen::Array3d(160.0, 175.0, 60.0) / spacing_mm).round().cast<int>();
    geometry.origin_mm = 0.5 * spacing_mm;
    volume::LabelMap labels(geometry);
    for (int k = 0; k < geometry.size[2]; ++k) {
      for (int j = 0; j < geometry.size[1]; ++j) {
        for (int i = 0; i < geometry.size[0]; ++i) {
          labels.At(i, j, k) =
              label_at((i + 0.5) * spacing_mm[0] - kFaceX, (j + 0.5) * spacing_mm[1] - kFaceY,
                       (k + 0.5) * spacing_mm[2] - kFaceZ);
        }
      }
    }
    labels.names = kNames;
    return labels;
  }

  template <typename Do>
  void Visit(double x, double depth, double half_x, double half_depth, const Do& act) const {
    for (int l = 0; l < grid_.lines(); ++l) {
      for (int k = 0; k < grid_.samples; ++k) {
        const auto n = static_cast<std::size_t>(l);
        const Eigen::Vector2d place = grid_.start_mm[n] + k * grid_.step_mm * grid_.direction[n];
        if (std::abs(place.x() - x) > half_x || std::abs(place.y() - depth) > half_depth) continue;
        const double range_cm = 0.1 * k * grid_.step_mm;
        const double gain_db =
            probe_.gain_db + std::min(probe_.tgc_db_per_cm * range_cm, tgc_limit_db_);
        act(20.0 * std::log10(std::max(1e-12, double{rows_[static_cast<std::size_t>(k)][n]})) +
                gain_db,
            place.x(), place.y());
      }
    }
  }
  template <typename Do>
  void VisitPixels(double x, double depth, double half_x, double half_depth, const Do& act) const {
    for (int r = 0; r < image_.height; ++r) {
      for (int c = 0; c < image_.width; ++c) {
        const Eigen::Vector3d place = geometry_.probe_from_image() * Eigen::Vector3d(c, r, 0.0);
        if (std::abs(place.x() - x) > half_x || std::abs(place.y() - depth) > half_depth) continue;
        act(image_.At(c, r));
      }
    }
  }

  volume::LabelMap labels_;
  acoustics::TissueAcousticsTable table_;
  acoustics::Probe probe_;
  double tgc_limit_db_ = 0.0;
  double slope_db_per_mm_ = 0.0;
  image::GrayImage image_;
  image::ImageGeometry geometry_;
  acoustics::ScanGrid grid_;
  std::vector<std::vector<float>> rows_;
};

struct Sign {
  std::string what;
  std::string unit;
  double low;
  double high;
  double measured;
  std::string source;

  bool inside() const { return measured >= low && measured <= high; }
};
constexpr double kAny = std::numeric_limits<double>::infinity();

/// Two tissues side by side below 20 mm of soft tissue: how much brighter the first is.
double BesideDb(const std::string& a, const std::string& b) {
  const Picture picture([&](double x, double depth, double) {
    return depth < 20.0 ? Of("soft_tissue") : Of(x < 0.0 ? a : b);
  });
  return picture.Level(-14.0, 24.2, 9.0, 1.8) - picture.Level(14.0, 24.2, 9.0, 1.8);
}

void AddParenchyma(std::vector<Sign>& signs) {
  signs.push_back({"liver over renal cortex", "dB", 0.0, 6.1, BesideDb("liver", "kidney"),
                   "Med. Ultrason. 2013;15:16, healthy 1.9 (0 to 6.1)"});
  signs.push_back(
      {"spleen over renal cortex", "dB", 1.0, 4.0, BesideDb("spleen", "kidney"), "estimate"});
  signs.push_back({"pancreas over liver", "dB", 0.5, 6.0, BesideDb("pancreas", "liver"),
                   "order of organs in textbooks; range: estimate"});
  signs.push_back({"blood against liver", "dB", -30.0, -20.0, BesideDb("vessel", "liver"),
                   "estimate, 3 to 5 MHz"});
  signs.push_back({"bile against liver", "dB", -kAny, -25.0, BesideDb("gallbladder", "liver"),
                   "anechoic; bound: estimate"});
  signs.push_back({"muscle across its fibres over fat", "dB", 3.0, 10.0, BesideDb("muscle", "fat"),
                   "muscle darker or brighter than fat by angle and septa; estimate"});
  Picture liver([](double, double, double) { return Of("liver"); });
  liver.RemoveSlope(0.45 - 0.55 * 0.35 * 2.0);
  signs.push_back({"liver: mean over standard deviation of the envelope", "1", 1.6, 1.95,
                   liver.SpeckleSnr(0.0, 50.0, 12.0), "1.91 for speckle, less with structure"});
  signs.push_back({"liver at 14 cm below liver at 8 cm", "grey", -200.0, -20.0,
                   liver.Grey(0.0, 140.0) - liver.Grey(0.0, 80.0), "estimate"});
  signs.push_back({"liver at 12 cm", "grey", 25.0, 255.0, liver.Grey(0.0, 120.0),
                   "seen to 12 cm at 3.5 MHz; estimate"});
  signs.push_back({"structure of liver, 2 mm squares", "grey", 3.0, 12.0,
                   liver.Structure(50.0, 15.0, 12.0), "estimate"});
  const Picture muscle([](double, double, double) { return Of("muscle"); });
  signs.push_back({"structure of muscle across its fibres, 2 mm squares", "grey", 12.0, 25.0,
                   muscle.Structure(30.0, 12.0, 12.0), "18 in recorded frames of a leg"});
  signs.push_back({"noise at 14 cm behind muscle", "grey", 0.0, 3.0, muscle.Grey(0.0, 140.0),
                   "0 in recorded frames"});
  const Picture fat([](double, double, double) { return Of("fat"); });
  signs.push_back({"structure of fat, 2 mm squares", "grey", 10.0, 30.0,
                   fat.Structure(30.0, 12.0, 12.0), "septa 3 to 10 mm apart; range: estimate"});
}

void AddKidney(std::vector<Sign>& signs) {
  const auto radius = [](double x, double depth, double z) {
    return std::hypot(x / 50.0, (depth - 55.0) / 26.0, z / 28.0);
  };
  const Picture picture([&](double x, double depth, double z) {
    return Of(radius(x, depth, z) < 1.0 ? "kidney" : "liver");
  });
  const double cortex = picture.Level(0.0, 33.5, 5.0, 1.8);
  signs.push_back({"renal sinus over cortex", "dB", 3.0, 15.0,
                   picture.Level(0.0, 55.0, 12.0, 7.0) - cortex, "brightest of the abdomen"});
  signs.push_back({"medulla against cortex", "dB", -8.0, -1.0,
                   picture.Level(0.0, 39.5, 12.0, 2.5) - cortex, "pyramids are darker"});
  signs.push_back({"renal capsule against liver, over liver", "dB", 6.0, 30.0,
                   picture.Peak(0.0, 29.0, 1.5, 2.0) - picture.Level(0.0, 22.0),
                   "bright line where it faces the beam; range: estimate"});
}

void AddFluid(std::vector<Sign>& signs) {
  const Picture bile([](double x, double depth, double) {
    return Of(std::abs(x) < 18.0 && depth > 40.0 && depth < 70.0 ? "gallbladder" : "liver");
  });
  signs.push_back({"behind 3 cm of bile, over liver beside it", "dB", 7.0, 14.0,
                   bile.Level(0.0, 82.0) - bile.Level(40.0, 82.0), "2 x 0.5 x 3 x 3.5 = 10"});
  signs.push_back({"wall of the gallbladder over liver", "dB", 6.0, 35.0,
                   bile.Peak(0.0, 40.0, 3.0, 2.0) - bile.Level(0.0, 34.0), "estimate"});
  signs.push_back({"bile", "grey", 0.0, 15.0, bile.Grey(0.0, 56.0), "anechoic"});
  const Picture vessel([](double x, double depth, double) {
    return Of(std::hypot(x, depth - 50.0) < 8.0 ? "vessel" : "liver");
  });
  signs.push_back({"wall of a vessel that faces the beam, over liver", "dB", 3.0, 30.0,
                   vessel.Peak(0.0, 42.0, 1.5, 1.5) - vessel.Level(0.0, 34.0), "estimate"});
}

void AddGasAndBone(std::vector<Sign>& signs) {
  const Picture diaphragm(
      [](double, double depth, double) { return Of(depth < 90.0 ? "liver" : "lung"); });
  signs.push_back({"diaphragm over liver", "dB", 15.0, 60.0,
                   diaphragm.Peak(0.0, 90.0, 3.0, 3.0) - diaphragm.Level(0.0, 80.0),
                   "brightest line of the abdomen; range: estimate"});
  const Picture pleura(
      [](double, double depth, double) { return Of(depth < 20.0 ? "muscle" : "lung"); });
  double first = 0.0;
  double second = 0.0;
  pleura.Peak(0.0, 20.0, 2.0, 3.0, &first);
  pleura.Peak(0.0, 40.0, 2.0, 6.0, &second);
  signs.push_back({"A-line: its depth over that of the pleura", "1", 1.95, 2.05, second / first,
                   "repeats at the distance from face to pleura (PMC7697535)"});
  const Picture bone([](double x, double depth, double) {
    return Of(std::abs(x) < 25.0 && depth > 40.0 && depth < 48.0 ? "bone" : "muscle");
  });
  signs.push_back({"bone over muscle", "dB", 20.0, 70.0,
                   bone.Peak(0.0, 40.0, 3.0, 3.0) - bone.Level(0.0, 34.0), "estimate"});
  signs.push_back({"shadow 2 cm behind bone", "grey", 0.0, 3.0, bone.Grey(0.0, 68.0),
                   "0 to 4 in recorded frames 8 mm behind"});
  signs.push_back(
      {"shadow 9 cm behind bone", "grey", 0.0, 3.0, bone.Grey(0.0, 138.0), "black on scanners"});
  signs.push_back({"far side of bone against its near side", "dB", -kAny, -40.0,
                   bone.Peak(0.0, 48.0, 3.0, 2.0) - bone.Peak(0.0, 40.0, 3.0, 2.0),
                   "one surface is seen"});
  const Picture thick(
      [](double x, double depth, double) {
        return Of(std::abs(x - 0.5) < 5.0 && depth > 30.0 && depth < 38.0 ? "bone" : "muscle");
      },
      {}, {5.0, 1.0, 1.0});
  signs.push_back({"rib in slices of 5 mm: far side against near side", "dB", -kAny, -30.0,
                   thick.Peak(0.0, 38.5, 1.0, 1.5) - thick.Peak(0.0, 30.0, 1.0, 2.0),
                   "one surface is seen"});
  signs.push_back({"rib in slices of 5 mm: shadow 1 cm behind", "grey", 0.0, 10.0,
                   thick.Grey(0.0, 50.0, 1.5, 2.0), "estimate"});
  const Picture beside([](double, double depth, double z) {
    return Of(z > 2.0 && z < 6.0 && depth > 40.0 && depth < 60.0 ? "bone" : "muscle");
  });
  const Picture without([](double, double, double) { return Of("muscle"); });
  signs.push_back({"bone 2 mm beside the plane against bone in it", "dB", -30.0, -6.0,
                   beside.Peak(0.0, 40.0, 2.0, 3.0) - bone.Peak(0.0, 40.0, 2.0, 3.0),
                   "weak and blurred; range: estimate"});
  signs.push_back({"its echo over muscle", "dB", 3.0, 40.0,
                   beside.Peak(0.0, 40.0, 2.0, 3.0) - without.Peak(0.0, 40.0, 2.0, 3.0),
                   "an echo wherever there is a shadow"});
  signs.push_back({"its shadow against muscle", "dB", -20.0, -1.0,
                   beside.Level(0.0, 54.0, 6.0, 4.0) - without.Level(0.0, 54.0, 6.0, 4.0),
                   "part of the beam passes; estimate"});
}

void AddSpine(std::vector<Sign>& signs) {
  const Picture spine([](double x, double depth, double) {
    if (depth < 40.0) return Of("muscle");
    if (depth < 46.0) return Of(std::abs(x) < 8.0 ? "ligament" : "bone");
    return Of(depth < 62.0 ? "spinal_canal" : "bone");
  });
  const double canal = spine.Level(0.0, 56.0, 3.0, 2.5);
  double flavum = 0.0;
  double dura = 0.0;
  const double posterior =
      std::max(spine.Peak(0.0, 46.0, 2.0, 1.0, &flavum), spine.Peak(0.0, 49.2, 2.0, 1.6, &dura));
  signs.push_back({"posterior complex over the canal", "dB", 10.0, 60.0, posterior - canal,
                   "flavum, gap, bright dura (aneskey.com)"});
  signs.push_back({"posterior dura below the flavum", "mm", 1.5, 6.0, dura - flavum,
                   "epidural space, two lines"});
  signs.push_back({"anterior complex over the canal", "dB", 15.0, 70.0,
                   spine.Peak(0.0, 62.0, 2.0, 2.5) - canal, "dura, ligament, vertebral body"});
  signs.push_back(
      {"canal between the complexes", "grey", 0.0, 40.0, spine.Grey(0.0, 56.0, 3.0, 2.5), "fluid"});
  signs.push_back({"shadow of the lamina", "grey", 0.0, 10.0, spine.Grey(22.0, 56.0, 4.0, 2.5),
                   "sawtooth with shadows"});
}

image::NeedleInImage NeedleAt(double degrees, double beside_mm) {
  const double a = degrees * std::numbers::pi / 180.0;
  const Eigen::Vector3d axis(std::cos(a), std::sin(a), 0.0);
  // Passes through the middle line 45 mm deep, 15 mm behind the tip.
  return {.tip_in_ct_mm = Eigen::Vector3d(0.0, 45.0, beside_mm) + 15.0 * axis,
          .axis_in_ct = axis,
          .length_mm = 120.0,
          .radius_mm = 0.635};
}

void AddNeedle(std::vector<Sign>& signs) {
  const LabelAt liver = [](double, double, double) { return Of("liver"); };
  const double background = Picture(liver).Peak(0.0, 45.0, 2.0, 4.0);
  const auto shaft = [&](double degrees, double beside_mm) {
    return Picture(liver, NeedleAt(degrees, beside_mm)).Peak(0.0, 45.0, 2.0, 4.0);
  };
  const double flat = shaft(10.0, 0.0);
  signs.push_back({"needle 30 degrees to the face, over the brightest speckle", "dB", 10.0, 60.0,
                   shaft(30.0, 0.0) - background, "good below 30 to 35 degrees (Kline 2015)"});
  signs.push_back({"needle 60 degrees to the face, over the brightest speckle", "dB", -3.0, 10.0,
                   shaft(60.0, 0.0) - background, "poor above 45 degrees (Kline 2015)"});
  signs.push_back({"needle at 45 degrees against one at 10", "dB", -40.0, -12.0,
                   shaft(45.0, 0.0) - flat, "specular: falls with the angle"});
  signs.push_back({"needle 5 mm beside the plane against one in it", "dB", -kAny, -20.0,
                   shaft(10.0, 5.0) - flat, "thickness of the slice"});
  const double a = 60.0 * std::numbers::pi / 180.0;
  const Picture steep(liver, NeedleAt(60.0, 0.0));
  signs.push_back({"tip over shaft, 60 degrees", "dB", 3.0, 30.0,
                   steep.Peak(15.0 * std::cos(a), 45.0 + 15.0 * std::sin(a), 2.0, 2.0) -
                       steep.Peak(0.0, 45.0, 2.0, 4.0),
                   "bevel and tip remain when the shaft is lost"});
  const Picture across(liver, NeedleAt(0.0, 0.0));
  double first = 0.0;
  double second = 0.0;
  across.Peak(0.0, 45.0, 0.6, 1.0, &first);
  across.Peak(0.0, first + 1.27, 0.6, 0.45, &second);
  signs.push_back({"reverberation within the needle: spacing over its diameter", "1", 0.85, 1.15,
                   (second - first) / 1.27, "walls of the shaft"});
}

const std::vector<Sign>& Signs() {
  static const std::vector<Sign> signs = [] {
    std::vector<Sign> all;
    AddParenchyma(all);
    AddKidney(all);
    AddFluid(all);
    AddGasAndBone(all);
    AddSpine(all);
    AddNeedle(all);
    return all;
  }();
  return signs;
}

std::string Number(double value, bool ratio) {
  char text[32];
  std::snprintf(text, sizeof text, ratio ? "%.2f" : "%.1f", value);
  return text;
}

std::string RangeText(const Sign& sign) {
  const bool ratio = sign.unit == "1";
  if (sign.low == -kAny) return "at most " + Number(sign.high, ratio);
  return Number(sign.low, ratio) + " to " + Number(sign.high, ratio);
}

std::string TableText() {
  std::ostringstream out;
  for (const Sign& sign : Signs()) {
    out << "| " << sign.what << " | " << sign.unit << " | " << RangeText(sign) << " | "
        << Number(sign.measured, sign.unit == "1") << " | " << (sign.inside() ? "yes" : "**no**")
        << " | " << sign.source << " |\n";
  }
  const auto inside =
      std::count_if(Signs().begin(), Signs().end(), [](const Sign& sign) { return sign.inside(); });
  out << "\n" << inside << " of " << Signs().size() << " signs are inside their range.\n";
  return out.str();
}

// The page states what is measured here, outside or inside.
TEST(SonographicSigns, ThePageHasWhatIsMeasured) {
  std::ifstream file(kRoot / "docs/models/ultrasound_signs.md");
  std::stringstream page;
  page << file.rdbuf();
  EXPECT_NE(page.str().find(TableText()), std::string::npos)
      << "docs/models/ultrasound_signs.md: its table should be\n"
      << TableText();
}

// No sign may be lost again.
TEST(SonographicSigns, MostAreInsideTheirRange) {
  for (const Sign& sign : Signs()) {
    if (!sign.inside()) std::printf("outside: %s, %.2f\n", sign.what.c_str(), sign.measured);
  }
  const auto inside =
      std::count_if(Signs().begin(), Signs().end(), [](const Sign& sign) { return sign.inside(); });
  EXPECT_GE(inside, 30);
}

}  // namespace
}  // namespace acus::ultrasound
