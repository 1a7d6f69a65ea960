#include "acus/patient/segmentation/voxels/scan_quality.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "acus/base/config/json_file.h"
#include "acus/base/core/text_table.h"
#include "acus/data/volume/label_map_content.h"
#include "acus/data/volume/labels.h"
#include "acus/patient/segmentation/segmenters/wall_muscles.h"

namespace acus::segmentation {
namespace {

using nlohmann::json;

constexpr double kShiftHu = 20.0;
constexpr double kAirShiftHu = 60.0;
constexpr double kSizeShift = 0.2;
constexpr int kMostOfBytes = 255;
constexpr double kMostBone = 0.6;  ///< Of the body; a head has a sixth, a wrist a third.
constexpr double kMostBoneWithoutAir = 0.3;
constexpr double kMostBodyWithoutAir = 0.999;
constexpr double kLeastSoftHu = 5.0;
constexpr double kMostSoftHu = 140.0;
constexpr double kMostNoiseHu = 45.0;
constexpr double kThickestMm = 5.0;
constexpr double kLeastCutShare = 0.01;
constexpr double kLeastBodyMl = 200.0;

/// direction 1: less bone, less lung, more fat; -1 the other way.
TissueOptions Shifted(TissueOptions o, double direction) {
  const double hu = direction * kShiftHu;
  const double size = 1.0 + direction * kSizeShift;
  o.body_threshold_hu += direction * kAirShiftHu;
  o.air_threshold_hu -= direction * kAirShiftHu;
  o.fat_upper_hu += hu;
  o.bone_lowest_hu += hu;
  o.bone_threshold_hu += hu;
  o.bone_certain_hu += hu;
  o.body_opening_mm *= size;
  o.lung_closing_mm *= size;
  o.bone_closing_mm *= size;
  o.contrast_core_mm *= size;
  o.contrast_max_spread *= size;
  return o;
}

/// Lowers the Dice of each tissue to that with `other`, and counts where it differs.
void Compare(const volume::LabelMap& labels, const volume::LabelMap& other, Certainty& out) {
  const auto ours = volume::CountsByLabel(labels);
  const auto theirs = volume::CountsByLabel(other);
  std::array<std::size_t, 256> both{};
  for (std::size_t i = 0; i < labels.voxels.size(); ++i) {
    if (labels.voxels[i] == other.voxels[i]) {
      ++both[labels.voxels[i]];
    } else {
      ++out.unsure.voxels[i];
    }
  }
  for (Certainty::Tissue& tissue : out.tissues) {
    const volume::Label label = volume::LabelOf(tissue.name);
    const auto sum = static_cast<double>(ours[label] + theirs[label]);
    if (sum > 0) tissue.dice = std::min(tissue.dice, 2.0 * static_cast<double>(both[label]) / sum);
  }
}

json ToJson(const ScanField& field) {
  json out = {{"padding_hu", nullptr}, {"circle_radius_mm", nullptr}};
  if (field.padding_hu) out["padding_hu"] = *field.padding_hu;
  if (field.circle) out["circle_radius_mm"] = field.circle->radius_mm;
  return out;
}

}  // namespace

Certainty FindCertainty(const volume::CtVolume& ct, const TissueOptions& options,
                        const volume::LabelMap& labels, const RunContext& context) {
  Certainty out;
  out.unsure = volume::Grid<std::uint8_t>(ct.geometry);
  const auto counts = volume::CountsByLabel(labels);
  for (const auto& [label, name] : labels.names) {
    if (label != 0 && counts[label] > 0) out.tissues.push_back({name, 1.0});
  }
  for (const double direction : {-1.0, 1.0}) {
    volume::LabelMap variant = FindTissues(ct, Shifted(options, direction), context).labels;
    AddWallMuscles(variant, context.num_threads);
    Compare(labels, variant, out);
  }
  const auto unsure = std::ranges::count_if(out.unsure.voxels, [](auto n) { return n > 0; });
  out.unsure_ml = static_cast<double>(unsure) * ct.geometry.voxel_volume_mm3() / 1000.0;
  return out;
}

void RequireCt(const volume::CtVolume& ct) {
  const auto [low, high] = std::ranges::minmax(ct.voxels);
  ACUS_REQUIRE(low < 0 || high > kMostOfBytes, "the values of the volume go from ", low, " to ",
               high,
               ": it is a mask, a label map or an image of 8 bits, and no CT in Hounsfield "
               "units; a label map is laid over a CT by --import");
}

std::vector<std::string> WarningsOf(const volume::CtVolume& ct, const TissuesFound& found) {
  const auto counts = volume::CountsByLabel(found.labels);
  const double ml = ct.geometry.voxel_volume_mm3() / 1000.0;
  const auto body = static_cast<double>(found.labels.voxels.size() - counts[0]);
  const auto part = [&](const char* name) {
    return static_cast<double>(counts[volume::LabelOf(name)]);
  };
  // Without a voxel of air, a volume is the inside of a body, or its values are not HU.
  const auto volume = static_cast<double>(found.labels.voxels.size());
  const bool has_air = body < kMostBodyWithoutAir * volume;
  // What is even and as dense as bone is taken for contrast agent.
  const double dense = part("bone") + (has_air ? 0.0 : found.scan.contrast_ml / ml);
  if (dense > (has_air ? kMostBone : kMostBoneWithoutAir) * body) {
    throw NoAnswerError(
        Message(FixedText(100.0 * dense / body, 0),
                " % of the body would be as dense as bone, which no patient has. The values "
                "are probably no Hounsfield units: check the rescale slope and "
                "intercept of the export"));
  }
  std::vector<std::string> warnings;
  if (part("bone") == 0.0) {
    warnings.push_back(
        "no bone was found. Check that the values are Hounsfield units and that the field of view "
        "shows bone; a mesh of these labels has no bone to hold it (fixed_tissues)");
  }
  const double soft_hu = found.scan.soft_tissue_hu;
  if (soft_hu < kLeastSoftHu || soft_hu > kMostSoftHu) {
    warnings.push_back(Message("the median of soft tissue is ", FixedText(soft_hu, 0), " HU; ",
                               FixedText(kLeastSoftHu, 0), " to ", FixedText(kMostSoftHu, 0),
                               " HU are usual. Check the rescale slope "
                               "and intercept of the export, or set the thresholds (--config)"));
  }
  if (body * ml < kLeastBodyMl) {
    warnings.push_back(Message("the body has only ", FixedText(body * ml, 0),
                               " ml. Is it a part of a patient, or has the table been taken for "
                               "it? Look at the previews"));
  }
  const double layer = part("skin") + part("cut");
  if (part("cut") > kLeastCutShare * layer) {
    warnings.push_back(Message("the scanner's round field of view cuts ",
                               FixedText(100.0 * part("cut") / layer, 0),
                               " % of the outer layer of the body. It is labelled cut, not skin: "
                               "no probe can stand there"));
  }
  if (found.scan.noise_hu > kMostNoiseHu) {
    warnings.push_back(Message("the noise is ", FixedText(found.scan.noise_hu, 0),
                               " HU. Small structures are not reliable; a softer reconstruction "
                               "kernel or thicker slices would help"));
  }
  if (ct.geometry.spacing_mm.maxCoeff() > kThickestMm) {
    warnings.push_back(Message("voxels are ", FixedText(ct.geometry.spacing_mm.maxCoeff(), 1),
                               " mm apart. Ribs, discs and ligaments are not resolved; use slices "
                               "of at most 3 mm"));
  }
  return warnings;
}

void WriteQuality(const std::filesystem::path& path, const ScanParameters& scan,
                  const std::vector<std::string>& warnings, const std::vector<PartQuality>& parts,
                  const std::optional<Certainty>& certainty) {
  json out = {{"format", "acus-segmentation-quality/1"},
              {"scan",
               {{"noise_hu", scan.noise_hu},
                {"soft_tissue_hu", scan.soft_tissue_hu},
                {"bone_threshold_hu", scan.bone_threshold_hu},
                {"contrast_agent", scan.enhanced},
                {"contrast_ml", scan.contrast_ml},
                {"spine_found", scan.has_spine},
                {"field_of_view", ToJson(scan.field)}}},
              {"warnings", warnings},
              {"parts", json::array()},
              {"certainty", nullptr}};
  for (const PartQuality& part : parts) {
    out["parts"].push_back(
        {{"name", part.name},
         {"sure", part.is_sure},
         {"certainty", part.certainty ? json(*part.certainty) : json(nullptr)},
         {"expected_dice", part.expected_dice ? json(*part.expected_dice) : json(nullptr)},
         {"why", part.why},
         {"look_at", part.look_at},
         {"correct", part.correct},
         {"in_labels", part.is_in_labels}});
  }
  if (certainty) {
    json tissues = json::object();
    for (const auto& tissue : certainty->tissues) tissues[tissue.name] = tissue.dice;
    out["certainty"] = {{"unsure_ml", certainty->unsure_ml}, {"dice_by_tissue", tissues}};
  }
  config::WriteJson(path, out);
}

}  // namespace acus::segmentation
