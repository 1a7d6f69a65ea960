// Repeats figures 10 and 11 of Fortmeier-2016 on the synthetic liver patient:
// fortmeier_breathing_images PATIENT_FOLDER OUT_FOLDER
#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>

#include "acus/base/core/parallel.h"
#include "acus/data/image/png.h"
#include "acus/physics/breathing/motion_map.h"
#include "support/breathing_liver.h"

namespace {

using namespace acus;  // NOLINT: a program of one file.
using breathing::MotionMap;
using Eigen::Array3d;
using Eigen::Vector3d;

/// Trilinear; air outside.
class Hounsfield {
 public:
  explicit Hounsfield(const volume::CtVolume& ct)
      : ct_(ct), index_from_ct_(ct.geometry.index_from_ct()) {}
  double At(const Vector3d& place_mm) const {
    const Vector3d index = index_from_ct_ * place_mm;
    const Eigen::Array3i last = ct_.geometry.size - 2;
    const Eigen::Array3i low = index.array().floor().cast<int>();
    if ((low < 0).any() || (low > last).any()) return -1000.0;
    const Array3d share = index.array() - low.cast<double>();
    double sum = 0.0;
    for (int n = 0; n < 8; ++n) {
      const Eigen::Array3i corner(n & 1, (n >> 1) & 1, n >> 2);
      const Array3d weight =
          corner.cast<double>() * share + (1 - corner).cast<double>() * (1.0 - share);
      const Eigen::Array3i at = low + corner;
      sum += weight.prod() * ct_.At(at[0], at[1], at[2]);
    }
    return sum;
  }

 private:
  const volume::CtVolume& ct_;
  Eigen::Affine3d index_from_ct_;
};

/// Tiles of one size, row by row, a few pixels of white between them.
class Sheet {
 public:
  Sheet(int columns, int rows, int width, int height) : width_(width), height_(height) {
    image_.Resize(columns * (width + kGap) - kGap, rows * (height + kGap) - kGap);
    std::ranges::fill(image_.rgb, std::uint8_t{255});
  }
  void Set(int column, int row, int x, int y, const Array3d& colour) {
    const std::size_t at = static_cast<std::size_t>(row * (height_ + kGap) + y) * image_.width +
                           column * (width_ + kGap) + x;
    for (std::size_t c = 0; c < 3; ++c) {
      image_.rgb[3 * at + c] = static_cast<std::uint8_t>(
          std::lround(255.0 * std::clamp(colour[static_cast<Eigen::Index>(c)], 0.0, 1.0)));
    }
  }
  void Write(const std::filesystem::path& path) const { image::WritePng(path, image_); }

 private:
  static constexpr int kGap = 4;
  int width_;
  int height_;
  image::ColourImage image_;
};

Array3d OfHue(double hue) {
  const auto part = [hue](double middle) {
    const double off = std::abs(std::remainder(hue - middle, 1.0));
    return std::clamp(2.0 - 6.0 * off, 0.0, 1.0);
  };
  return {part(0.0), part(1.0 / 3.0), part(2.0 / 3.0)};
}

double Grey(double hu) {
  return (hu + 200.0) / 500.0;
}

/// A sagittal slice through the right lung and the liver: y to the right, z up.
struct Slice {
  static constexpr double kPixelMm = 1.25;
  double x_mm;
  Vector3d corner_mm;  ///< Front, head.
  int width;
  int height;

  explicit Slice(const volume::Geometry& ct) : x_mm(-70.0) {
    const Vector3d last = ct.ct_from_index() * (ct.size - 1).cast<double>().matrix();
    corner_mm = {x_mm, ct.origin_mm.y(), last.z()};
    width = static_cast<int>((last.y() - ct.origin_mm.y()) / kPixelMm);
    height = static_cast<int>((last.z() - ct.origin_mm.z()) / kPixelMm);
  }
  Vector3d At(int x, int y) const { return corner_mm + kPixelMm * Vector3d(0.0, x, -y); }
};

/// Fig. 10: the model's slice at a moment; hue: which way tissue has moved, opaque at 10 mm.
void PaintMoment(const MotionMap& map, const Hounsfield& hu, const Slice& slice, int column,
                 int row, Sheet& sheet) {
  ParallelFor(slice.height, 2, [&](int y) {
    Vector3d moved = Vector3d::Zero();
    for (int x = 0; x < slice.width; ++x) {
      const Vector3d place = slice.At(x, y);
      const Vector3d rest =
          map.RestOf(place, place + moved, {.max_iterations = 5, .tolerance_mm = 0.0}).rest_mm;
      moved = rest - place;
      const double value = hu.At(rest);
      const double opacity = value < -500.0 && moved.norm() < 0.5
                                 ? 0.0
                                 : std::min(1.0, std::hypot(moved.y(), moved.z()) / 10.0);
      const Array3d colour = OfHue(std::atan2(-moved.z(), -moved.y()) / (2.0 * M_PI));
      sheet.Set(column, row, x, y,
                (1.0 - 0.6 * opacity) * Array3d::Constant(Grey(value)) + 0.6 * opacity * colour);
    }
  });
}

void DrawFigure10(const testing_support::BreathingLiver& patient,
                  const std::filesystem::path& out) {
  const Hounsfield hu(patient.ct);
  const Slice slice(patient.ct.geometry);
  Sheet sheet(5, 2, slice.width, slice.height);
  int row = 0;
  for (const auto kind : {breathing::MotionKind::kHalfCycle, breathing::MotionKind::kSurrogate}) {
    const breathing::MotionModel model = patient.Model(kind);
    int column = 0;
    for (const double cycle : {0.0, 0.25, 0.5, 0.75}) {
      PaintMoment({model.field(), model.WeightsAt(patient.BreathAt(cycle))}, hu, slice, column++,
                  row, sheet);
    }
    PaintMoment({model.field(), model.WeightsAt(patient.BreathAt(0.0, 1.4))}, hu, slice, column,
                row, sheet);
    ++row;
  }
  sheet.Write(out / "fortmeier_10.png");
}

/// Fig. 11, lower: 0, 1, 5, 50 iterations from nothing; below each, how far it is from where it
/// should be, white at 5 mm.
void DrawFigure11Slices(const MotionMap& map, const Hounsfield& hu, const Slice& slice,
                        const std::filesystem::path& out) {
  Sheet sheet(4, 2, slice.width, slice.height);
  int column = 0;
  for (const int iterations : {0, 1, 5, 50}) {
    double sum = 0.0, largest = 0.0;
    for (int y = 0; y < slice.height; ++y) {
      for (int x = 0; x < slice.width; ++x) {
        const Vector3d place = slice.At(x, y);
        const auto found =
            map.RestOf(place, place, {.max_iterations = iterations, .tolerance_mm = 0.0});
        sheet.Set(column, 0, x, y, Array3d::Constant(Grey(hu.At(found.rest_mm))));
        sheet.Set(column, 1, x, y, Array3d::Constant(found.residual_mm / 5.0));
        sum += found.residual_mm;
        largest = std::max(largest, found.residual_mm);
      }
    }
    std::cout << "slice, " << iterations << " iterations: residual "
              << sum / (slice.width * slice.height) << " mm in the mean, " << largest
              << " mm at most\n";
    ++column;
  }
  sheet.Write(out / "fortmeier_11_slices.png");
}

/// How rays are bent.
struct Scheme {
  bool inverts = true;      ///< False: the place itself is taken for the rest.
  bool from_before = true;  ///< From the sample before, eq. 2; false: from the place itself.
  double step_mm = 1.0;
};

constexpr double kBoneHu = 350.0;

/// Fig. 11, upper: bones by parallel rays from the front and above. The paper shows a navel, which
/// this patient has none of; at the ribs, along which organs slide, rays are bent most.
struct BoneView {
  static constexpr int kWidth = 240;
  static constexpr int kHeight = 240;
  static constexpr double kPixelMm = 0.85;
  static constexpr double kReachMm = 260.0;
  Vector3d middle_mm;
  Vector3d ray = Vector3d(0.0, 1.0, -0.55).normalized();
  Vector3d right = Vector3d::UnitX();
  Vector3d up = right.cross(ray);

  Vector3d Eye(int x, int y) const {
    return middle_mm - 130.0 * ray + kPixelMm * ((x - kWidth / 2) * right - (y - kHeight / 2) * up);
  }
};

/// Distance along each ray to where `threshold` is passed, and |X + u(X) - x| there.
struct Surface {
  std::vector<double> depth_mm;
  std::vector<double> residual_mm;
};
Surface CastRays(const MotionMap& map, const Hounsfield& hu, const BoneView& view,
                 double threshold_hu, const Scheme& scheme) {
  Surface out;
  out.depth_mm.assign(BoneView::kWidth * BoneView::kHeight, BoneView::kReachMm);
  out.residual_mm.assign(out.depth_mm.size(), 0.0);
  ParallelFor(BoneView::kHeight, 2, [&](int y) {
    for (int x = 0; x < BoneView::kWidth; ++x) {
      const Vector3d eye = view.Eye(x, y);
      Vector3d rest = eye;
      double before = -1000.0;
      for (double along = 0.0; along < BoneView::kReachMm; along += scheme.step_mm) {
        const Vector3d place = eye + along * view.ray;
        const Vector3d start = scheme.from_before ? rest + scheme.step_mm * view.ray : place;
        rest = scheme.inverts ? Vector3d(place - map.DisplacementMm(start)) : place;
        const double value = hu.At(rest);
        if (value > threshold_hu) {
          const auto n = static_cast<std::size_t>(y * BoneView::kWidth + x);
          out.depth_mm[n] =
              along - scheme.step_mm * (value - threshold_hu) / std::max(1.0, value - before);
          out.residual_mm[n] = (map.WorldMm(rest) - place).norm();
          break;
        }
        before = value;
      }
    }
  });
  return out;
}

void PaintSurface(const Surface& surface, int column, Sheet& sheet) {
  const Vector3d lamp = Vector3d(-0.5, 0.5, 0.7).normalized();
  const auto depth = [&](int x, int y) {
    return surface.depth_mm[static_cast<std::size_t>(y * BoneView::kWidth + x)];
  };
  for (int y = 1; y + 1 < BoneView::kHeight; ++y) {
    for (int x = 1; x + 1 < BoneView::kWidth; ++x) {
      const auto n = static_cast<std::size_t>(y * BoneView::kWidth + x);
      Array3d colour(0.08, 0.09, 0.11);
      if (depth(x, y) < BoneView::kReachMm) {
        const double dx = (depth(x + 1, y) - depth(x - 1, y)) / (2.0 * BoneView::kPixelMm);
        const double dy = (depth(x, y + 1) - depth(x, y - 1)) / (2.0 * BoneView::kPixelMm);
        const Vector3d normal = Vector3d(dx, -dy, 1.0).normalized();
        colour = Array3d(0.93, 0.80, 0.70) * (0.15 + 0.85 * std::max(0.0, normal.dot(lamp)));
      }
      sheet.Set(column, 0, x, y, colour);
      sheet.Set(column, 1, x, y, Array3d::Constant(surface.residual_mm[n] / 5.0));
    }
  }
}

void DrawFigure11Rays(const MotionMap& map, const Hounsfield& hu, const BoneView& view,
                      const std::filesystem::path& file) {
  Sheet sheet(4, 2, BoneView::kWidth, BoneView::kHeight);
  const std::array<Scheme, 4> schemes{Scheme{.inverts = false}, Scheme{.from_before = false},
                                      Scheme{}, Scheme{.step_mm = 0.5}};
  for (int column = 0; column < 4; ++column) {
    const Surface surface =
        CastRays(map, hu, view, kBoneHu, schemes[static_cast<std::size_t>(column)]);
    PaintSurface(surface, column, sheet);
    double sum = 0.0;
    int seen = 0;
    for (std::size_t n = 0; n < surface.depth_mm.size(); ++n) {
      if (surface.depth_mm[n] >= BoneView::kReachMm) continue;
      sum += surface.residual_mm[n];
      ++seen;
    }
    std::cout << "rays, image " << column + 1 << ": residual " << sum / std::max(1, seen)
              << " mm in the mean\n";
  }
  sheet.Write(file);
}

void Draw(const std::filesystem::path& folder, const std::filesystem::path& out) {
  // A deep breath, so that the schemes differ as they do in the paper.
  const testing_support::BreathingLiver patient(
      folder, {.diaphragm_mm = 30.0, .chest_mm = 12.0, .hysteresis_mm = 4.0});
  DrawFigure10(patient, out);
  const breathing::MotionModel model = patient.Model(breathing::MotionKind::kSurrogate);
  const MotionMap map(model.field(), model.WeightsAt(patient.BreathAt(0.0)));
  const Hounsfield hu(patient.ct);
  const Slice slice(patient.ct.geometry);
  DrawFigure11Slices(map, hu, slice, out);
  BoneView view;
  view.middle_mm = patient.ct.geometry.ct_from_index() *
                   (0.5 * (patient.ct.geometry.size - 1).cast<double>().matrix());
  DrawFigure11Rays(map, hu, view, out / "fortmeier_11_rays.png");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::cerr << "usage: fortmeier_breathing_images PATIENT_FOLDER OUT_FOLDER\n";
    return 2;
  }
  try {
    Draw(argv[1], argv[2]);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
  return 0;
}
