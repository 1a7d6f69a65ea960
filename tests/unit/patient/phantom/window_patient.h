// The label map that tests of targets and windows share: the trunk of the synthetic patient.
#pragma once

#include "acus/patient/phantom/anatomy/patient_field.h"
#include "acus/patient/phantom/planning/body_frame.h"
#include "unit/patient/phantom/presets.h"

namespace acus::phantom {

/// The anatomy of seed 1 at 2.5 mm, from the pelvis to the lungs, made once.
struct WindowPatient {
  WindowPatient() : labels(Made()), field(labels), frame(labels) {}

  static const WindowPatient& Get() {
    static const WindowPatient kPatient;
    return kPatient;
  }

  volume::LabelMap labels;
  LabelMapField field;
  BodyFrame frame;

 private:
  static volume::LabelMap Made() {
    const Anatomy anatomy(Preset("liver").body, 1);
    volume::Geometry g;
    g.spacing_mm = Eigen::Array3d::Constant(2.5);
    g.size = {144, 105, 110};
    g.origin_mm = {-179.0, -165.0, -80.0};
    volume::LabelMap labels(g);
    for (int k = 0; k < g.size[2]; ++k) {
      for (int j = 0; j < g.size[1]; ++j) {
        for (int i = 0; i < g.size[0]; ++i)
          labels.At(i, j, k) = anatomy.LabelAt(g.ct_from_index() * Eigen::Vector3d(i, j, k));
      }
    }
    return labels;
  }
};

}  // namespace acus::phantom
