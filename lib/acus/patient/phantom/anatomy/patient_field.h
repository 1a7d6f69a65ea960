// What is at a point of a patient: exact anatomy, or a label map.
#pragma once

#include <optional>

#include "acus/data/volume/volume.h"
#include "acus/patient/phantom/anatomy/anatomy.h"

namespace acus::phantom {

class PatientField {
 public:
  virtual ~PatientField() = default;
  virtual volume::Label LabelAt(const Eigen::Vector3d& point_ct_mm) const = 0;

  /// About the distance to the skin, > 0 outside. Its zero is the surface on which probes lie.
  virtual double SkinDistanceMm(const Eigen::Vector3d& point_ct_mm) const = 0;

  /// Where the field is known: the volume's extent.
  virtual Box bounds_ct_mm() const = 0;

  /// Whether the field of view, not air, ends the body near this point of its surface: no place for
  /// a needle or a probe.
  virtual bool IsCut(const Eigen::Vector3d& /*point_ct_mm*/) const { return false; }

  /// Around the body.
  virtual Box body_ct_mm() const { return bounds_ct_mm(); }
};

class AnatomyField : public PatientField {
 public:
  AnatomyField(const Anatomy& anatomy, const volume::Geometry& geometry);
  volume::Label LabelAt(const Eigen::Vector3d& p) const override { return anatomy_.LabelAt(p); }
  double SkinDistanceMm(const Eigen::Vector3d& p) const override {
    return anatomy_.SkinDistanceMm(p);
  }
  Box bounds_ct_mm() const override { return bounds_; }

 private:
  const Anatomy& anatomy_;
  Box bounds_;
};

/// Labels by nearest voxel; label 0 is outside the body. The skin is the half level of the body
/// smoothed by a Gaussian of 2.5 mm, so that a probe does not climb the stairs of the voxels. Where
/// the circle of the scanner's reconstruction, centred in the slices, cuts the body, and beside the
/// label cut, the surface is a cut.
class LabelMapField : public PatientField {
 public:
  /// What lies beyond the volume where it cuts the body: more of it, or air, so that the border
  /// takes the place of the skin.
  enum class Beyond { kSame, kAir };

  /// `labels` must outlive this object.
  explicit LabelMapField(const volume::LabelMap& labels, Beyond beyond = Beyond::kSame);
  volume::Label LabelAt(const Eigen::Vector3d& p) const override;
  double SkinDistanceMm(const Eigen::Vector3d& p) const override;
  bool IsCut(const Eigen::Vector3d& p) const override;
  Box bounds_ct_mm() const override { return bounds_; }
  Box body_ct_mm() const override { return body_; }

 private:
  /// 1 in the body, 0 outside, linear between voxel centres.
  double BodyAt(const Eigen::Vector3d& p) const;

  const volume::LabelMap& labels_;
  Beyond beyond_;
  Eigen::Affine3d index_from_ct_;
  Box bounds_;
  Box body_;
  double cut_radius_mm_;  ///< Of the circle that cuts the body; infinite if none does.
};

/// The point of the skin nearest to `start` on the line along `direction`, within `reach_mm` to
/// either side; at it the line goes from inside to outside in the sense of `direction`.
std::optional<Eigen::Vector3d> SkinAlong(const PatientField& field, const Eigen::Vector3d& start,
                                         const Eigen::Vector3d& direction, double reach_mm);

/// Unit normal of the skin, outwards, of a plane through the skin 10 mm around the point.
Eigen::Vector3d SkinNormal(const PatientField& field, const Eigen::Vector3d& point_ct_mm);

}  // namespace acus::phantom
