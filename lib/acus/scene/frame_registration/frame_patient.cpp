#include "acus/scene/frame_registration/frame_patient.h"

#include <algorithm>

#include "acus/base/core/error.h"
#include "acus/data/volume/labels.h"
#include "acus/data/volume/volume_io.h"
#include "acus/patient/segmentation/surfaces/surface_scene.h"

namespace acus::frame_registration {
namespace {

namespace fs = std::filesystem;

/// Indices of the voxels in a box of CT space, first and last; not limited to the volume.
struct IndexBox {
  Eigen::Array3i low;
  Eigen::Array3i high;
};

IndexBox IndicesOf(const volume::Geometry& geometry, const Eigen::AlignedBox3d& box_mm) {
  const Eigen::AlignedBox3d index = box_mm.transformed(geometry.index_from_ct());
  return {index.min().array().floor().cast<int>(), index.max().array().ceil().cast<int>()};
}

IndexBox Within(const volume::Geometry& geometry, IndexBox box) {
  box.low = box.low.max(0);
  box.high = box.high.min(geometry.size - 1);
  ACUS_REQUIRE(
      (box.low <= box.high).all(),
      "nothing of the patient is near the field of view at the start; check that the start "
      "takes points of the probe to this CT (LPS, mm)");
  return box;
}

/// The voxels of a box, with `beyond` where it leaves the volume.
template <typename Volume, typename Voxel>
void CopyBox(const Volume& from, const IndexBox& box, Voxel beyond, Volume& to) {
  volume::Geometry g = from.geometry;
  g.size = box.high - box.low + 1;
  g.origin_mm = from.geometry.ct_from_index() * box.low.template cast<double>().matrix();
  to.geometry = g;
  to.voxels.assign(static_cast<std::size_t>(g.size.template cast<std::int64_t>().prod()), beyond);
  const IndexBox inner = Within(from.geometry, box);
  for (int k = inner.low[2]; k <= inner.high[2]; ++k) {
    for (int j = inner.low[1]; j <= inner.high[1]; ++j) {
      const auto first = static_cast<std::ptrdiff_t>(from.geometry.Index(inner.low[0], j, k));
      const auto out = static_cast<std::ptrdiff_t>(
          g.Index(inner.low[0] - box.low[0], j - box.low[1], k - box.low[2]));
      std::copy_n(from.voxels.begin() + first, inner.high[0] - inner.low[0] + 1,
                  to.voxels.begin() + out);
    }
  }
}

void RequirePath(const fs::path& path, const char* what) {
  ACUS_REQUIRE(!path.empty(), "the scenario's ultrasound reads ", what,
               ", and there are none; give --", what, " FILE");
  ACUS_REQUIRE(fs::exists(path), path.string(), ": no such file (", what, " of the patient)");
}

volume::LabelMap ReadLabels(const scenario::Patient& patient, RunContext& context) {
  if (!patient.surfaces.empty()) {
    context.provenance.AddInput(patient.surfaces);
    const auto list = segmentation::ReadSurfaceScene(patient.surfaces);
    for (const auto& surface : list.surfaces) context.provenance.AddInput(surface.file);
    return segmentation::LabelsOfSurfaces(list, context);
  }
  RequirePath(patient.labels, "labels");
  context.provenance.AddInput(patient.labels);
  return volume::ReadTissues(patient.labels);
}

}  // namespace

SimulatedTissue FramePatient::tissue() const {
  return {.tissue = {.ct = ct ? &*ct : nullptr,
                     .labels = labels ? &*labels : nullptr,
                     .acoustics = &settings.acoustics},
          .options = settings.options};
}

Eigen::AlignedBox3d FieldOfViewBox(const acoustics::Probe& probe,
                                   const Eigen::Isometry3d& ct_from_probe, double margin_mm) {
  const acoustics::ScanGrid grid = acoustics::BeamGridOf(probe);
  Eigen::AlignedBox3d box;
  for (std::size_t n = 0; n < grid.start_mm.size(); ++n) {
    for (const double depth_mm : {0.0, (grid.samples - 1) * grid.step_mm}) {
      const Eigen::Vector2d at = grid.start_mm[n] + depth_mm * grid.direction[n];
      box.extend(ct_from_probe * Eigen::Vector3d(at.x(), at.y(), 0.0));
    }
  }
  return {box.min().array() - margin_mm, box.max().array() + margin_mm};
}

volume::LabelMap LabelsAround(const volume::LabelMap& labels, const Eigen::AlignedBox3d& box_mm,
                              const std::string& background) {
  IndexBox box = IndicesOf(labels.geometry, box_mm);
  if (background.empty()) box = Within(labels.geometry, box);
  const volume::Label fill = background.empty() ? volume::Label{0} : volume::LabelOf(background);
  volume::LabelMap out;
  CopyBox(labels, box, fill, out);
  out.names = labels.names;
  if (background.empty()) return out;
  out.names[fill] = background;
  std::ranges::replace(out.voxels, volume::Label{0}, fill);
  return out;
}

FramePatient ReadFramePatient(const scenario::Scenario& scenario, const std::string& background,
                              const acoustics::Probe& probe, const Eigen::Isometry3d& start,
                              double margin_mm, RunContext& context) {
  ACUS_REQUIRE(
      scenario.ultrasound && scenario.ultrasound->model == scenario::UltrasoundModel::kAperture,
      scenario.file.string(),
      ": /effects/ultrasound/model: must be 'aperture', the model that frames are compared "
      "with");
  FramePatient out;
  out.settings = simulation::ReadApertureSettings(*scenario.ultrasound, nullptr);
  context.provenance.AddInput(scenario.ultrasound->acoustics);
  const Eigen::AlignedBox3d box = FieldOfViewBox(probe, start, margin_mm);
  const bool from_surfaces = !scenario.patient.surfaces.empty();
  if (out.settings.from_ct && !from_surfaces) {
    RequirePath(scenario.patient.ct, "ct");
    context.provenance.AddInput(scenario.patient.ct);
    const auto ct = volume::ReadCt(scenario.patient.ct, scenario.patient.dicom_series, context);
    out.ct.emplace();
    CopyBox(ct, Within(ct.geometry, IndicesOf(ct.geometry, box)), std::int16_t{-1024}, *out.ct);
    ACUS_REQUIRE(background.empty(),
                 "--background is for labels or surfaces without a CT; leave it "
                 "out, or set the ultrasound's volume to 'labels'");
  }
  if (out.settings.from_labels || from_surfaces) {
    out.labels = LabelsAround(ReadLabels(scenario.patient, context), box, background);
  }
  return out;
}

}  // namespace acus::frame_registration
