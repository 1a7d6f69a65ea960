#include "acus/patient/segmentation/surfaces/skin_surface.h"

#include "acus/data/volume/label_lookup.h"
#include "acus/data/volume/labels.h"

namespace acus::segmentation {
namespace {

bool IsInVolume(const volume::Geometry& g, const Eigen::Vector3d& index) {
  return (index.array() >= -0.5).all() && (index.array() <= g.size.cast<double>() - 0.5).all();
}

/// The first of `skin` and `cut` behind a place of the surface.
bool IsOnCut(const volume::LabelMap& labels, const Eigen::Affine3d& index_from_ct,
             const Eigen::Vector3d& at_mm, const Eigen::Vector3d& inwards, double reach_mm) {
  static const volume::Label kCut = volume::LabelOf("cut");
  static const volume::Label kSkin = volume::LabelOf("skin");
  constexpr int kSteps = 8;
  for (int n = 0; n <= kSteps; ++n) {
    const volume::Label label =
        volume::LabelAt(labels, index_from_ct, at_mm + n * reach_mm / kSteps * inwards);
    if (label == kCut || label == kSkin) return label == kCut;
  }
  return false;
}

}  // namespace

mesh::Surface SkinOf(const mesh::Surface& body, const volume::LabelMap& labels, double reach_mm) {
  const Eigen::Affine3d index_from_ct = labels.geometry.index_from_ct();
  mesh::Surface skin = body;
  Eigen::Index count = 0;
  for (Eigen::Index t = 0; t < body.triangles.cols(); ++t) {
    const Eigen::Vector3d a = body.nodes_mm.col(body.triangles(0, t));
    const Eigen::Vector3d b = body.nodes_mm.col(body.triangles(1, t));
    const Eigen::Vector3d c = body.nodes_mm.col(body.triangles(2, t));
    const Eigen::Vector3d outwards = (b - a).cross(c - a).normalized();
    const Eigen::Vector3d middle_mm = (a + b + c) / 3.0;
    if (!IsInVolume(labels.geometry, index_from_ct * (middle_mm + reach_mm * outwards)) ||
        IsOnCut(labels, index_from_ct, middle_mm, -outwards, reach_mm)) {
      continue;
    }
    skin.triangles.col(count++) = body.triangles.col(t);
  }
  skin.triangles.conservativeResize(3, count);
  return mesh::WithoutUnusedNodes(skin);
}

}  // namespace acus::segmentation
