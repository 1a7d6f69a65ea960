#include "acus/patient/segmentation/patient_segmentation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/text_table.h"
#include "acus/base/core/words.h"
#include "acus/data/mesh/surface_io.h"
#include "acus/data/volume/label_map_content.h"
#include "acus/data/volume/labels.h"
#include "acus/data/volume/volume_io.h"
#include "acus/patient/segmentation/muscle_smoothing.h"
#include "acus/patient/segmentation/preview.h"
#include "acus/patient/segmentation/quality_page.h"
#include "acus/patient/segmentation/segmenters/wall_muscles.h"
#include "acus/patient/segmentation/spine/spine.h"
#include "acus/patient/segmentation/surfaces/skin_surface.h"
#include "acus/patient/segmentation/voxels/metrics.h"

namespace acus::segmentation {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

SurfaceOptions SurfaceFrom(const json& node) {
  SurfaceOptions options;
  options.grid_mm = node.at("grid_mm");
  options.smoothing_iterations = node.at("smoothing_iterations");
  options.smoothing_pass_band = node.at("smoothing_pass_band");
  options.target_triangles = node.at("target_triangles");
  options.min_part_ml = node.at("min_part_ml");
  return options;
}

OrganSeed OrganFrom(const json& node) {
  OrganSeed organ;
  organ.tissue = node.at("tissue");
  volume::LabelOf(organ.tissue);  // Refuses an unknown name.
  for (const auto& point : node.at("seeds_mm")) {
    organ.points_mm.emplace_back(point.at(0).get<double>(), point.at(1).get<double>(),
                                 point.at(2).get<double>());
  }
  organ.method = node.at("method") == "level_set" ? OrganSeed::Method::kLevelSet
                                                  : OrganSeed::Method::kRegionGrowing;
  organ.lower_hu = node.at("lower_hu");
  organ.upper_hu = node.at("upper_hu");
  organ.radius_mm = node.at("radius_mm");
  organ.smoothing_mm = node.at("smoothing_mm");
  organ.curvature_weight = node.at("curvature_weight");
  organ.iterations = node.at("iterations");
  return organ;
}

/// Skin and bone stay; everything else inside the body may be organ.
void AddOrgan(const Mask& organ, const std::string& tissue, volume::LabelMap& labels) {
  const volume::Label label = volume::LabelOf(tissue);
  const volume::Label skin = volume::LabelOf("skin");
  const volume::Label bone = volume::LabelOf("bone");
  for (std::size_t i = 0; i < organ.voxels.size(); ++i) {
    const volume::Label here = labels.voxels[i];
    if (organ.voxels[i] != 0 && here != 0 && here != skin && here != bone) labels.voxels[i] = label;
  }
  labels.names[label] = tissue;
}

Agreement Agree(const std::string& tissue, const Mask& ours, const Mask& reference,
                const RunContext& context) {
  const double ml = ours.geometry.voxel_volume_mm3() / 1000.0;
  Agreement agreement;
  agreement.tissue = tissue;
  agreement.dice = Dice(ours, reference);
  agreement.surface_distance95_mm = SurfaceDistance95Mm(ours, reference, context.num_threads);
  agreement.ours_ml = static_cast<double>(Count(ours)) * ml;
  agreement.reference_ml = static_cast<double>(Count(reference)) * ml;
  return agreement;
}

void WriteVolumes(const fs::path& path, const volume::LabelMap& labels) {
  const auto count = volume::CountsByLabel(labels);
  std::string text = "label,name,volume_ml\n";
  for (const auto& [label, name] : labels.names) {
    if (label == 0) continue;
    const double ml =
        static_cast<double>(count[label]) * labels.geometry.voxel_volume_mm3() / 1000.0;
    text += Message(int{label}, ",", name, ",", NumberText(std::round(ml * 1000.0) / 1000.0), "\n");
  }
  WriteTextFile(path, text);
}

void WriteVertebrae(const fs::path& folder, const Vertebrae& vertebrae) {
  volume::WriteLabelMap(folder / "vertebrae.seg.nrrd", vertebrae.labels);
  std::string text = "name,whole,x_mm,y_mm,z_mm,volume_ml\n";
  for (const Vertebra& v : vertebrae.list) {
    text += Message(v.name, ",", v.is_whole ? 1 : 0, ",", FixedText(v.centre_mm[0], 1), ",",
                    FixedText(v.centre_mm[1], 1), ",", FixedText(v.centre_mm[2], 1), ",",
                    FixedText(v.volume_ml, 2), "\n");
  }
  WriteTextFile(folder / "vertebrae.csv", text);
}

/// The volume, and its axial slice with the most unsure voxels.
void WriteUnsure(const fs::path& folder, const volume::CtVolume& ct, const Certainty& certainty) {
  volume::LabelMap map(ct.geometry);
  map.voxels = certainty.unsure.voxels;
  map.names = {{1, "unsure"}, {2, "unsure_both_ways"}};
  volume::WriteLabelMap(folder / "unsure.nrrd", map);
  const int axis = AxialAxis(ct.geometry);
  std::vector<std::size_t> counts(static_cast<std::size_t>(ct.geometry.size[axis]), 0);
  for (int k = 0; k < ct.geometry.size[2]; ++k) {
    for (int j = 0; j < ct.geometry.size[1]; ++j) {
      for (int i = 0; i < ct.geometry.size[0]; ++i) {
        const std::array at = {i, j, k};
        if (map.At(i, j, k) != 0) {
          ++counts[static_cast<std::size_t>(at[static_cast<std::size_t>(axis)])];
        }
      }
    }
  }
  Eigen::Array3i voxel = ct.geometry.size / 2;
  voxel[axis] = static_cast<int>(std::ranges::max_element(counts) - counts.begin());
  WritePreview(folder / "preview_unsure.png", ct, map, Plane::kAxial, voxel);
}

/// None, with a warning: a CT of soft tissue alone has no bone, and the rest is still of use.
std::optional<mesh::Surface> SurfaceOf(const std::string& name, const Mask& mask,
                                       const SurfaceOptions& options, const RunContext& context) {
  try {
    return ExtractSurface(mask, options, context.num_threads);
  } catch (const InputError& error) {
    context.Warn(Message(name, ".stl is not written: ", error.what()));
    return std::nullopt;
  }
}

/// With contrast agent, edges within a kidney look like those of its surface, so that the expected
/// Dice is too high.
void DoubtKidneysWithContrast(std::vector<OrganCheck>& organs) {
  for (OrganCheck& organ : organs) {
    if (!organ.expected_dice || !organ.name.starts_with("kidney")) continue;
    organ.doubts.emplace_back("with contrast agent, edges within it count as its surface");
  }
}

/// body.stl and skin.stl.
void WriteBody(const fs::path& folder, const volume::LabelMap& labels,
               const SurfaceOptions& options, const RunContext& context) {
  const auto body = SurfaceOf("body", BodyOf(labels), options, context);
  if (!body) return;
  mesh::WriteSurface(folder / "body.stl", *body);
  const mesh::Surface skin = SkinOf(*body, labels, options.grid_mm);
  if (skin.triangles.cols() > 0) {
    mesh::WriteSurface(folder / "skin.stl", skin);
  } else {
    context.Warn("skin.stl is not written: the edges of the CT cut the body all around");
  }
}

}  // namespace

SegmentationConfig ReadSegmentationConfig(const fs::path& path) {
  const json document = config::ReadConfig(path, "acus-segmentation");
  SegmentationConfig config;
  TissueOptions& t = config.tissues;
  const json& body = document.at("body");
  t.body_threshold_hu = body.at("threshold_hu");
  t.body_opening_mm = body.at("opening_mm");
  t.body_min_part_ml = body.at("min_part_ml");
  t.skin_thickness_mm = body.at("skin_thickness_mm");
  t.fat_upper_hu = document.at("fat_upper_hu");
  const json& air = document.at("air");
  t.air_threshold_hu = air.at("threshold_hu");
  t.gas_median_hu = air.at("gas_median_hu");
  t.lung_min_ml = air.at("lung_min_ml");
  t.lung_closing_mm = air.at("lung_closing_mm");
  const json& bone = document.at("bone");
  t.bone_lowest_hu = bone.at("lowest_hu");
  t.bone_threshold_hu = bone.at("threshold_hu");
  t.bone_certain_hu = bone.at("certain_hu");
  t.bone_min_part_ml = bone.at("min_part_ml");
  t.bone_closing_mm = bone.at("closing_mm");
  t.contrast_core_mm = bone.at("contrast_core_mm");
  t.contrast_max_spread = bone.at("contrast_max_spread");
  ACUS_REQUIRE(t.bone_lowest_hu <= t.bone_threshold_hu && t.bone_threshold_hu <= t.bone_certain_hu,
               path.string(),
               ": /bone: lowest_hu, threshold_hu and certain_hu must be in that order, got ",
               t.bone_lowest_hu, ", ", t.bone_threshold_hu, ", ", t.bone_certain_hu);
  for (const json& organ : document.at("organs")) config.organs.push_back(OrganFrom(organ));
  config.skin_surface = SurfaceFrom(document.at("skin_surface"));
  config.bone_surface = SurfaceFrom(document.at("bone_surface"));
  return config;
}

TissuesFound SegmentPatient(const volume::CtVolume& ct, const SegmentationConfig& config,
                            const RunContext& context) {
  RequireCt(ct);
  TissuesFound found = FindTissues(ct, config.tissues, context);
  volume::LabelMap& labels = found.labels;
  for (const OrganSeed& organ : config.organs) {
    context.Checkpoint(Message("finding the ", organ.tissue), 0.0);
    AddOrgan(FindOrgan(ct, organ, context), organ.tissue, labels);
  }
  context.Checkpoint("finding muscles", 0.0);
  AddWallMuscles(labels, context.num_threads);
  SmoothMuscles(ct, config.tissues.fat_upper_hu, labels);
  return found;
}

SegmentedPatient Examine(const volume::CtVolume& ct, const SegmentationConfig& config,
                         TissuesFound found, const Examination& examination,
                         const RunContext& context) {
  SegmentedPatient patient;
  patient.warnings = WarningsOf(ct, found);
  if (examination.certainty) {
    patient.certainty = FindCertainty(ct, config.tissues, found.labels, context);
  }
  context.Checkpoint("naming vertebrae", 0.0);
  patient.vertebrae =
      FindVertebrae(ct, found.labels, examination.start,
                    examination.vertebrae.voxels.empty() ? nullptr : &examination.vertebrae);
  patient.organs = CheckOrgans(found.labels, examination.organs);
  if (found.scan.enhanced) DoubtKidneysWithContrast(patient.organs);
  patient.parts =
      PartsOf(found.labels, found.scan, patient.vertebrae, patient.organs, context.num_threads);
  patient.scan = found.scan;
  patient.labels = std::move(found.labels);
  return patient;
}

std::string SummaryOf(const SegmentedPatient& patient) {
  const auto counts = volume::CountsByLabel(patient.labels);
  const double ml = patient.labels.geometry.voxel_volume_mm3() / 1000.0;
  std::vector<std::string> parts;
  double body_ml = 0.0;
  for (const auto& [label, name] : patient.labels.names) {
    if (label == 0 || counts[label] == 0) continue;
    body_ml += static_cast<double>(counts[label]) * ml;
    parts.push_back(Message(name, " ", FixedText(static_cast<double>(counts[label]) * ml, 0)));
  }
  const ScanParameters& scan = patient.scan;
  std::string text = Message(
      "Body ", FixedText(body_ml, 0), " ml: ", Joined(parts), ".\n", "Bone from ",
      FixedText(scan.bone_threshold_hu, 0), " HU; soft tissue ", FixedText(scan.soft_tissue_hu, 0),
      " HU, noise ", FixedText(scan.noise_hu, 0), " HU; ", scan.enhanced ? "with" : "without",
      " contrast agent.\n", SpineSentence(patient.labels), VertebraeSentence(patient.vertebrae));
  if (patient.certainty) {
    std::vector<std::string> tissues;
    for (const auto& tissue : patient.certainty->tissues) {
      tissues.push_back(Message(tissue.name, " ", FixedText(tissue.dice, 2)));
    }
    text += Message("Unsure: ", FixedText(100.0 * patient.certainty->unsure_ml / body_ml, 1),
                    " % of the body. Dice with other thresholds: ", Joined(tissues), ".\n");
  }
  return text + "\n" + PartsTable(patient.parts);
}

std::vector<Agreement> CompareWithReference(const volume::LabelMap& labels,
                                            const ForeignLabels& reference,
                                            const RunContext& context) {
  ImportedLabels import = ReadImportedLabels(reference, labels.geometry, context);
  const volume::LabelMap truth = TissuesIn(import);
  std::vector<Agreement> agreement;
  if (import.mapping.covers_body) {
    context.Checkpoint("comparing the body", 0.0);
    // Values without a tissue of their own are body as well.
    for (auto& [value, tissue] : import.mapping.tissue) tissue = volume::LabelOf("soft_tissue");
    const volume::LabelMap body = TissuesIn(import);
    agreement.push_back(Agree("body", BodyOf(labels), BodyOf(body), context));
  }
  std::vector<std::string> not_found;
  for (const auto& [label, name] : truth.names) {
    const Mask theirs = MaskOf(truth, label);
    if (label == 0 || Count(theirs) == 0) continue;
    context.Checkpoint(Message("comparing ", name), 0.0);
    const Mask ours = MaskOf(labels, label);
    if (Count(ours) == 0) {
      not_found.push_back(name);
    } else {
      agreement.push_back(Agree(name, ours, theirs, context));
    }
  }
  if (!not_found.empty()) {
    context.Warn(Message("not compared, because only the reference has them: ", Joined(not_found)));
  }
  if (agreement.empty()) {
    throw NoAnswerError(Message(reference.file.string(),
                                ": has no tissue in common with the segmentation; "
                                "is the mapping the right one?"));
  }
  return agreement;
}

std::string AgreementTable(const std::vector<Agreement>& agreement) {
  std::vector<std::vector<std::string>> rows;
  for (const Agreement& a : agreement) {
    rows.push_back({a.tissue, FixedText(a.dice, 4), FixedText(a.surface_distance95_mm, 2),
                    FixedText(a.reference_ml, 1), FixedText(a.ours_ml, 1)});
  }
  return TextTable({"tissue", "Dice", "HD95 mm", "reference ml", "ours ml"}, rows);
}

volume::LabelMap TissuesOf(const volume::CtVolume& ct, const fs::path& labels,
                           RunContext& context) {
  if (labels.empty()) {
    const fs::path preset = config::FindConfig("segmentation/default.json", ".");
    return SegmentPatient(ct, ReadSegmentationConfig(preset), context).labels;
  }
  context.provenance.AddInput(labels);
  volume::LabelMap map = volume::ReadTissues(labels);
  ACUS_REQUIRE(map.geometry.Matches(ct.geometry), labels.string(),
               ": lies on another grid than the CT; segment this CT");
  return map;
}

void WritePatientFolder(const fs::path& folder, const volume::CtVolume& ct,
                        const SegmentedPatient& patient, const SegmentationConfig& config,
                        const RunContext& context) {
  AtomicFolder out(folder, context.overwrite);
  const volume::LabelMap& labels = patient.labels;
  context.Checkpoint("writing labels", 0.0);
  volume::WriteLabelMap(out.path() / "labels.seg.nrrd", labels);
  WriteVolumes(out.path() / "volumes.csv", labels);
  context.Checkpoint("drawing previews", 0.3);
  WritePreviews(out.path(), ct, WithDoubtsInNames(labels, patient.organs));
  context.Checkpoint("extracting the skin", 0.5);
  WriteBody(out.path(), labels, config.skin_surface, context);
  context.Checkpoint("extracting the bone", 0.8);
  const Mask bone = MaskOf(labels, volume::LabelOf("bone"));
  if (const auto surface = SurfaceOf("bone", bone, config.bone_surface, context)) {
    mesh::WriteSurface(out.path() / "bone.stl", *surface);
  }
  WriteViews(out.path(), labels);
  WriteQualityPage(out.path(), patient, context.provenance.ToJson());
  WriteQuality(out.path() / "quality.json", patient.scan, patient.warnings, patient.parts,
               patient.certainty);
  if (!patient.vertebrae.empty()) WriteVertebrae(out.path(), patient.vertebrae);
  if (patient.certainty) WriteUnsure(out.path(), ct, *patient.certainty);
  if (!patient.agreement.empty()) {
    std::string text = "tissue,dice,surface_distance95_mm,reference_ml,ours_ml\n";
    for (const Agreement& a : patient.agreement) {
      text += Message(a.tissue, ",", NumberText(a.dice), ",", NumberText(a.surface_distance95_mm),
                      ",", NumberText(a.reference_ml), ",", NumberText(a.ours_ml), "\n");
    }
    WriteTextFile(out.path() / "agreement.csv", text);
  }
  config::WriteJson(out.path() / "provenance.json", context.provenance.ToJson());
  out.Commit();
}

}  // namespace acus::segmentation
