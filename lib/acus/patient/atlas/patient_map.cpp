#include "acus/patient/atlas/patient_map.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "acus/base/core/parallel.h"
#include "acus/data/volume/label_lookup.h"
#include "acus/data/volume/labels.h"
#include "acus/patient/atlas/affine_alignment.h"
#include "acus/patient/atlas/hu_density.h"
#include "acus/patient/breathing_registration/phase_registration.h"
#include "acus/patient/segmentation/voxels/crop.h"
#include "acus/patient/segmentation/voxels/line_filter.h"

namespace acus::atlas {
namespace {

using breathing_registration::ModelImage;
using breathing_registration::PhaseField;
using breathing_registration::PhaseRegistration;
using breathing_registration::Side;
using Eigen::Vector3d;
using Eigen::Vector3f;
using segmentation::Mask;
using volume::Grid;

constexpr double kAlignmentMm = 6.0;  // Grid on which bodies are aligned.
constexpr int kLevels = 4, kIterations = 20;
constexpr double kSmoothness = 1.0;   // Patients differ more smoothly than one patient breathes.
constexpr double kFirstNoise = 40.0;  // Before the organs' HU are known ...
constexpr double kNoise = 20.0;       // ... and after.
constexpr int kColourings = 2;
constexpr double kLikenessMm = 6.0;        // Over which the differences of two CTs are averaged.
constexpr std::size_t kLeastVoxels = 200;  // Of an organ whose HU is taken.
constexpr double kOrganDepthMm = 6.0, kVesselDepthMm = 3.0;
constexpr int kPeakBlurHu = 10;

/// Labels whose HU distinguish them from the tissue around them.
constexpr std::array kColoured = {"liver", "kidney", "spleen",   "vessel",  "lesion",
                                  "bowel", "heart",  "pancreas", "stomach", "gallbladder"};

volume::CtVolume Rounded(const Grid<float>& image) {
  volume::CtVolume out(image.geometry);
  for (std::size_t n = 0; n < out.voxels.size(); ++n) {
    out.voxels[n] = static_cast<std::int16_t>(std::lround(image.voxels[n]));
  }
  return out;
}

/// The part of the patient that the atlas has too, and the atlas bent onto it.
class Carrier {
 public:
  Carrier(const LabelledPatient& atlas, const PatientImage& atlas_image,
          const PatientImage& patient, const Eigen::Affine3d& atlas_from_patient,
          const RunContext& context)
      : atlas_(atlas),
        atlas_image_(atlas_image),
        patient_(patient),
        atlas_from_patient_(atlas_from_patient),
        context_(context) {
    const Eigen::Affine3d index_from_patient_index = atlas_image.geometry().index_from_ct() *
                                                     atlas_from_patient *
                                                     patient.geometry().ct_from_index();
    const Eigen::Array3d last = (atlas_image.geometry().size - 1).cast<double>();
    Mask covered(patient.geometry());
    const Eigen::Array3i& size = covered.geometry.size;
    for (int k = 0; k < size[2]; ++k) {
      for (int j = 0; j < size[1]; ++j) {
        for (int i = 0; i < size[0]; ++i) {
          const Eigen::Array3d at = (index_from_patient_index * Vector3d(i, j, k)).array();
          covered.At(i, j, k) =
              patient.body().At(i, j, k) != 0 && (at >= 0.0).all() && (at <= last).all();
        }
      }
    }
    box_ = segmentation::BoundsOf(covered);
    if (!box_.empty()) covered_ = segmentation::Cropped(covered, box_);
  }

  bool empty() const { return box_.empty(); }

  /// Bends the atlas until `atlas` agrees with `patient`; both over the whole of their grids.
  void Bend(const Grid<float>& patient, const Grid<float>& atlas, double noise) {
    breathing_registration::RegistrationSettings settings;
    settings.spacing_mm = covered_.geometry.spacing_mm[0];
    settings.levels = kLevels;
    settings.iterations = kIterations;
    settings.smoothness = kSmoothness;
    settings.noise = noise;
    const Eigen::Affine3d index_from_ct = covered_.geometry.index_from_ct();
    const auto is_tissue = [&](const Vector3d& p) {
      const Eigen::Array3i v = (index_from_ct * p).array().round().cast<int>();
      return covered_.geometry.Contains(v[0], v[1], v[2]) && covered_.At(v[0], v[1], v[2]) != 0;
    };
    const PhaseRegistration registration(Rounded(segmentation::Cropped(patient, box_)),
                                         {.is_tissue = is_tissue, .wall_mm = {}}, settings,
                                         context_);
    const volume::CtVolume aligned = Rounded(Aligned(atlas));
    field_ = registration.Register(aligned, field_ ? &*field_ : nullptr, context_);
    difference_ = registration.Difference(aligned, &*field_, context_.num_threads);
  }

  volume::LabelMap Organs() const {
    volume::LabelMap out(covered_.geometry);
    const Eigen::Affine3d ct_from_index = covered_.geometry.ct_from_index();
    const Eigen::Affine3d voxel_from_ct = atlas_.organs.geometry.index_from_ct();
    ParallelFor(out.geometry.size[2], context_.num_threads, [&](int k) {
      for (int j = 0; j < out.geometry.size[1]; ++j) {
        for (int i = 0; i < out.geometry.size[0]; ++i) {
          if (covered_.At(i, j, k) == 0) continue;
          const Vector3d at = ct_from_index * Vector3d(i, j, k);
          const Vector3d bent =
              field_ ? Vector3d(at + field_->DisplacementMm(at, Side::kWall)) : at;
          out.At(i, j, k) =
              volume::LabelAt(atlas_.organs, voxel_from_ct, atlas_from_patient_ * bent);
        }
      }
    });
    return out;
  }

  std::map<volume::Label, double> OrganHu(const Grid<float>& hu,
                                          const volume::LabelMap& organs) const {
    std::map<volume::Label, double> found;
    for (const char* name : kColoured) {
      const volume::Label label = volume::LabelOf(name);
      const Mask mask = segmentation::MaskOf(organs, label);
      if (segmentation::Count(mask) < kLeastVoxels) continue;
      const bool thin = label == volume::LabelOf("vessel");
      found[label] =
          MostFrequentHu(hu, mask, thin ? kVesselDepthMm : kOrganDepthMm, context_.num_threads);
    }
    return found;
  }

  /// Median HU of soft tissue to which the atlas gives no label.
  double SoftHu(const Grid<float>& hu, const volume::LabelMap& organs) const {
    std::vector<float> values;
    for (std::size_t n = 0; n < hu.voxels.size(); ++n) {
      const bool soft = hu.voxels[n] > -20.0F && hu.voxels[n] < 130.0F;
      if (soft && covered_.voxels[n] != 0 && organs.voxels[n] == 0) values.push_back(hu.voxels[n]);
    }
    if (values.empty()) return patient_.soft_hu();
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::ranges::nth_element(values, middle);
    return *middle;
  }

  /// On the patient's whole coarse grid.
  CarriedLabels Result(const volume::LabelMap& organs, const volume::LabelMap& aligned,
                       std::map<volume::Label, double> organ_hu) const {
    CarriedLabels out{.organs = volume::LabelMap(patient_.geometry()),
                      .aligned = volume::LabelMap(patient_.geometry()),
                      .covered = Mask(patient_.geometry()),
                      .likeness = Grid<float>(patient_.geometry()),
                      .organ_hu = std::move(organ_hu)};
    segmentation::Paste<volume::Label>(organs, box_, out.organs);
    segmentation::Paste<volume::Label>(aligned, box_, out.aligned);
    segmentation::Paste(covered_, box_, out.covered);
    segmentation::Paste(Likeness(), box_, out.likeness);
    return out;
  }

  const segmentation::Box& box() const { return box_; }

 private:
  /// Likeness of the images that were bent last. @pre Bend was called.
  Grid<float> Likeness() const {
    Grid<float> squares(covered_.geometry);
    ACUS_REQUIRE(squares.voxels.size() == difference_.voxels.size(),
                 "atlas: the grid of the registration is another than that of the body");
    std::ranges::transform(difference_.voxels, squares.voxels.begin(),
                           [](float difference) { return difference * difference; });
    squares = segmentation::Blurred(squares, kLikenessMm, context_.num_threads);
    for (float& square : squares.voxels) {
      square = 1.0F / (square + static_cast<float>(kNoise * kNoise));
    }
    return squares;
  }

  /// The atlas's image on the patient's grid; beyond its edge as at the edge.
  Grid<float> Aligned(const Grid<float>& atlas) const {
    const ModelImage image(atlas, context_.num_threads);
    const Eigen::Affine3d index =
        atlas.geometry.index_from_ct() * atlas_from_patient_ * covered_.geometry.ct_from_index();
    const Eigen::Array3f last = (atlas.geometry.size - 1).cast<float>();
    Grid<float> out(covered_.geometry);
    ParallelFor(out.geometry.size[2], context_.num_threads, [&](int k) {
      for (int j = 0; j < out.geometry.size[1]; ++j) {
        for (int i = 0; i < out.geometry.size[0]; ++i) {
          const Vector3f at = (index * Vector3d(i, j, k)).cast<float>();
          out.At(i, j, k) = image.At(at.array().max(0.0F).min(last).matrix()).value;
        }
      }
    });
    return out;
  }

  const LabelledPatient& atlas_;
  const PatientImage& atlas_image_;
  const PatientImage& patient_;
  Eigen::Affine3d atlas_from_patient_;
  const RunContext& context_;
  segmentation::Box box_;
  Mask covered_;
  std::optional<PhaseField> field_;
  Grid<float> difference_;  ///< Between the bent atlas and the patient.
};

}  // namespace

double MostFrequentHu(const Grid<float>& hu, const Mask& region, double depth_mm, int num_threads) {
  Mask deep = segmentation::Eroded(region, depth_mm, num_threads);
  if (segmentation::Count(deep) < kLeastVoxels / 4) deep = region;
  HuDensity density(kPeakBlurHu, 0.0);
  for (std::size_t n = 0; n < hu.voxels.size(); ++n) {
    // Fat and bone within the outline of an organ are not the organ.
    const bool soft = hu.voxels[n] > -20.0F && hu.voxels[n] < 300.0F;
    if (deep.voxels[n] != 0 && soft) density.Add(hu.voxels[n]);
  }
  density.Normalise();
  return density.Peak();
}

std::optional<CarriedLabels> CarryLabels(const LabelledPatient& atlas, const PatientImage& patient,
                                         const RunContext& context) {
  const int num_threads = context.num_threads;
  const double spacing_mm = patient.geometry().spacing_mm[0];
  const PatientImage atlas_image(atlas.ct, atlas.tissues, spacing_mm);
  const auto coarse = [&](const Grid<float>& image) {
    return breathing_registration::Averaged(
        image, breathing_registration::CubicGrid(image.geometry, kAlignmentMm), num_threads);
  };
  const auto coarse_mask = [&](const Mask& mask, const volume::Geometry& grid) {
    Mask out(grid);
    const Eigen::Affine3d index = mask.geometry.index_from_ct() * grid.ct_from_index();
    for (int k = 0; k < grid.size[2]; ++k) {
      for (int j = 0; j < grid.size[1]; ++j) {
        for (int i = 0; i < grid.size[0]; ++i) {
          const Eigen::Array3i v = (index * Vector3d(i, j, k)).array().round().cast<int>();
          out.At(i, j, k) = mask.At(v[0], v[1], v[2]);
        }
      }
    }
    return out;
  };
  const Grid<float> first = patient.Comparable(patient.soft_hu(), num_threads);
  const Grid<float> atlas_first = atlas_image.Comparable(atlas_image.soft_hu(), num_threads);
  const Grid<float> small = coarse(first), atlas_small = coarse(atlas_first);
  const auto affine = AlignBodies(small, coarse_mask(patient.body(), small.geometry),
                                  ModelImage(atlas_small, num_threads),
                                  coarse_mask(atlas_image.body(), atlas_small.geometry));
  if (!affine) return std::nullopt;
  Carrier carrier(atlas, atlas_image, patient, *affine, context);
  if (carrier.empty()) return std::nullopt;
  const volume::LabelMap aligned = carrier.Organs();
  carrier.Bend(first, atlas_first, kFirstNoise);
  volume::LabelMap organs = carrier.Organs();
  const Grid<float> hu = segmentation::Cropped(patient.Hu(num_threads), carrier.box());
  const double soft_hu = carrier.SoftHu(hu, organs);
  const Grid<float> image = patient.Comparable(soft_hu, num_threads);
  std::map<volume::Label, double> organ_hu;
  for (int n = 0; n < kColourings; ++n) {
    context.Checkpoint("carrying organs over", static_cast<double>(n + 1) / (kColourings + 1));
    organ_hu = carrier.OrganHu(hu, organs);
    carrier.Bend(image, atlas_image.Imitated(atlas.organs, organ_hu, soft_hu, num_threads), kNoise);
    organs = carrier.Organs();
  }
  return carrier.Result(organs, aligned, carrier.OrganHu(hu, organs));
}

}  // namespace acus::atlas
