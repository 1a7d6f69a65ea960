#include "benchmarks/image_scene.h"

#include <cmath>

#include "acus/base/config/json_file.h"
#include "acus/base/core/random.h"
#include "acus/data/volume/labels.h"

namespace acus::benchmarks {
namespace {

struct Tissue {
  const char* name;
  double hu;
};

Tissue TissueAt(double x_mm, double y_mm, double z_mm) {
  if (std::hypot(x_mm - 45.0, y_mm - 14.0) < 3.5) return {"bone", 900.0};
  if (std::hypot(x_mm - 16.0, y_mm - 34.0) < 4.0) return {"vessel", 45.0};
  if (Eigen::Vector3d(x_mm - 30.0, y_mm - 30.0, z_mm - 15.0).norm() < 6.0) return {"lesion", 40.0};
  if (y_mm < 2.0) return {"skin", 20.0};
  if (y_mm < 8.0) return {"fat", -100.0};
  if (y_mm < 18.0) return {"muscle", 55.0};
  return {"liver", 65.0};
}

}  // namespace

ImageScene MakeImageScene() {
  ImageScene scene;
  volume::Geometry geometry;
  geometry.size = {120, 120, 60};
  geometry.spacing_mm.setConstant(0.5);
  geometry.origin_mm.setConstant(0.25);
  scene.labels = volume::LabelMap(geometry);
  scene.ct = volume::CtVolume(geometry);
  RandomStream random(1, "voxel noise");
  for (int k = 0; k < 60; ++k) {
    for (int j = 0; j < 120; ++j) {
      for (int i = 0; i < 120; ++i) {
        const Tissue tissue = TissueAt(0.5 * i, 0.5 * j, 0.5 * k);
        const volume::Label label = volume::LabelOf(tissue.name);
        scene.labels.At(i, j, k) = label;
        scene.labels.names[label] = tissue.name;
        scene.ct.At(i, j, k) =
            static_cast<std::int16_t>(std::lround(tissue.hu + random.Uniform(-15.0, 15.0)));
      }
    }
  }
  scene.acoustics =
      acoustics::ReadTissueAcoustics(config::FindConfig("acoustics/tissues.json", "."));
  scene.ct_from_probe =
      Eigen::Translation3d(30.0, 0.3, 15.0) * Eigen::AngleAxisd(0.15, Eigen::Vector3d::UnitY());
  scene.needle.tip_in_ct_mm << 27.0, 26.0, 15.0;
  scene.needle.axis_in_ct = Eigen::Vector3d(0.7, 0.7, 0.05).normalized();
  scene.needle.length_mm = 80.0;
  scene.needle.radius_mm = 0.45;
  return scene;
}

Eigen::Vector3d PressedTissue::RestInCtMm(const Eigen::Vector3d& place_in_ct_mm,
                                          const Eigen::Vector3d& /*guess*/) const noexcept {
  Eigen::Vector3d rest = place_in_ct_mm;
  for (int n = 0; n < iterations_; ++n) {
    const double near = std::exp(-(rest - tip_mm_).squaredNorm() / 100.0);
    rest = place_in_ct_mm - 2.0 * near * Eigen::Vector3d(0.7, 0.7, 0.1);
  }
  return rest;
}

}  // namespace acus::benchmarks
