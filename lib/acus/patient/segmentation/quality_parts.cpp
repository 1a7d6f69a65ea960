#include "acus/patient/segmentation/quality_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "acus/base/config/json_file.h"
#include "acus/base/core/text_table.h"
#include "acus/base/core/words.h"
#include "acus/data/volume/label_map_content.h"
#include "acus/data/volume/labels.h"
#include "acus/patient/segmentation/canal_check.h"

namespace acus::segmentation {
namespace {

constexpr double kThinSlicesMm = 3.2;  ///< Discs and ligaments are a few mm thick.
constexpr double kNoisyHu = 45.0;
constexpr double kMostCutShare = 0.05;

/// Shares of right cases in the half of the copies by which they were measured, (right + 1) /
/// (all + 2): the table "Certainty" of docs/models/segmentation.md; of organs, the cases of
/// testdata/organ_evidence.csv.
struct MeasuredShare {
  std::string_view part;
  double without_doubt, with_doubt;
};
constexpr std::array kMeasuredShares = {
    MeasuredShare{"bone", 0.96, 0.83}, MeasuredShare{"spinal_canal", 0.93, 0.83},
    MeasuredShare{"disc", 0.88, 0.36}, MeasuredShare{"organ of an atlas", 0.80, 0.17}};

const char* const kSlices = "preview_*.png, labels.seg.nrrd (3D Slicer)";

/// "L3=1.0,2.0,3.0" with the centre of a whole vertebra in the middle of the list.
std::string ExampleOfName(const Vertebrae& vertebrae) {
  const Vertebra& middle = vertebrae.list[vertebrae.list.size() / 2];
  const Eigen::Vector3d& p = middle.centre_mm;
  return Message("--vertebra NAME=", FixedText(p.x(), 1), ",", FixedText(p.y(), 1), ",",
                 FixedText(p.z(), 1), " with the name of ", middle.name);
}

PartQuality NamesPart(const Vertebrae& vertebrae) {
  PartQuality part{
      .name = "names of vertebrae",
      .is_sure = vertebrae.doubt.empty() && vertebrae.named_from != NamedFrom::kLastRib,
      .why = Message(vertebrae.list.front().name, " to ", vertebrae.list.back().name),
      .look_at = "",
      .correct = ""};
  if (part.is_sure) return part;
  part.why += vertebrae.doubt.empty()
                  ? "; from the last pair of ribs alone, which in some people is not that of T12"
                  : "; " + vertebrae.doubt;
  part.look_at = "preview_sagittal.png, vertebrae.seg.nrrd";
  part.correct = ExampleOfName(vertebrae);
  return part;
}

PartQuality Judged(const std::string& name, const std::string& why, const std::string& doubt,
                   const std::string& correct) {
  if (doubt.empty())
    return {.name = name, .is_sure = true, .why = why, .look_at = "", .correct = ""};
  return {.name = name,
          .is_sure = false,
          .why = why.empty() ? doubt : Message(doubt, "; ", why),
          .look_at = kSlices,
          .correct = correct};
}

/// What is right too seldom, although nothing speaks against it, is unsure as well.
PartQuality WithCertainty(PartQuality part, std::string_view kind) {
  const auto* measured = std::ranges::find(kMeasuredShares, kind, &MeasuredShare::part);
  const double certainty = part.is_sure ? measured->without_doubt : measured->with_doubt;
  if (part.is_sure && certainty < kLeastCertainty) {
    part = Judged(part.name, part.why, "too seldom right in tests", "--import MASK");
  }
  part.certainty = certainty;
  return part;
}

PartQuality OrganPart(const OrganCheck& organ) {
  std::string why =
      Message(FixedText(organ.volume_ml, 0), " ml; of adults ", FixedText(organ.least_ml, 0),
              " to ", FixedText(organ.most_ml, 0), " ml");
  if (organ.expected_dice) why += Message("; expected Dice ", FixedText(*organ.expected_dice, 2));
  PartQuality part = Judged(organ.name, why, Joined(organ.doubts),
                            "--import MASK, or a seed in /organs of --config");
  if (!organ.expected_dice) return part;
  part = WithCertainty(std::move(part), "organ of an atlas");
  part.expected_dice = organ.expected_dice;
  return part;
}

/// Noise, and what the canal of the map itself shows; no case was measured that failed these
/// checks.
PartQuality CanalPart(const volume::LabelMap& labels, double ml, const std::string& noisy,
                      int num_threads) {
  CanalCheck check = CheckCanal(labels, num_threads);
  const bool is_measured = check.doubts.empty();
  if (!noisy.empty()) check.doubts.push_back(noisy);
  PartQuality part = Judged("spinal_canal",
                            Message(FixedText(ml, 0), " ml, ", FixedText(check.area_mm2, 0),
                                    " mm2 over ", FixedText(check.length_mm, 0), " mm"),
                            Joined(check.doubts, "; "), "--import MASK");
  return is_measured ? WithCertainty(part, "spinal_canal") : part;
}

std::string CertaintyText(const PartQuality& part) {
  return part.certainty ? Message(FixedText(100.0 * *part.certainty, 0), " %") : "";
}

}  // namespace

std::vector<PartQuality> PartsOf(const volume::LabelMap& labels, const ScanParameters& scan,
                                 const Vertebrae& vertebrae, const std::vector<OrganCheck>& organs,
                                 int num_threads) {
  const auto counts = volume::CountsByLabel(labels);
  const double ml = labels.geometry.voxel_volume_mm3() / 1000.0;
  const auto volume_of = [&](const char* name) {
    return static_cast<double>(counts[volume::LabelOf(name)]) * ml;
  };
  const auto text_of = [&](const char* name) { return FixedText(volume_of(name), 0) + " ml"; };
  const double slices_mm = labels.geometry.spacing_mm.maxCoeff();
  const std::string thick =
      slices_mm > kThinSlicesMm
          ? Message("voxels of ", FixedText(slices_mm, 1), " mm do not resolve them")
          : std::string();
  const std::string noisy = scan.noise_hu > kNoisyHu
                                ? Message("noise of ", FixedText(scan.noise_hu, 0), " HU")
                                : std::string();
  std::vector<PartQuality> parts;
  for (const OrganCheck& organ : organs) parts.push_back(OrganPart(organ));
  if (!vertebrae.empty()) {
    parts.push_back(NamesPart(vertebrae));
    parts.back().is_in_labels = false;
  }
  if (volume_of("spinal_canal") > 0.0) {
    parts.push_back(CanalPart(labels, volume_of("spinal_canal"), noisy, num_threads));
  } else {
    parts.push_back(Judged("spinal_canal", "",
                           "no closed rings of bone were found, so that the spine has no parts",
                           "--import MASK, or a CT with thinner slices"));
    parts.back().is_in_labels = false;
  }
  for (const char* name : {"disc", "ligament"}) {
    if (volume_of(name) == 0.0) continue;
    parts.push_back(Judged(name, text_of(name), thick.empty() ? noisy : thick,
                           "--import MASK, or a CT with slices of at most 3 mm"));
    if (parts.back().name == "disc") parts.back() = WithCertainty(parts.back(), "disc");
  }
  parts.push_back(WithCertainty(
      Judged("bone", text_of("bone"), volume_of("bone") == 0.0 ? "none was found" : noisy,
             "--import MASK, or thresholds in /bone of --config"),
      "bone"));
  const double cut = volume_of("cut");
  const double layer = volume_of("skin") + cut;
  parts.push_back(Judged(
      "skin", text_of("skin"),
      layer <= 0.0 ? "the CT shows no skin: nothing can be planned from it"
      : cut > kMostCutShare * layer
          ? Message("the scanner's circle cuts ", FixedText(100.0 * cut / layer, 0), " % of it")
          : std::string(),
      "a reconstruction with a larger field of view"));
  return parts;
}

std::string PartsTable(const std::vector<PartQuality>& parts) {
  std::vector<std::vector<std::string>> rows;
  std::string corrections;
  for (const PartQuality& part : parts) {
    rows.push_back({part.name, part.is_sure ? "sure" : "UNSURE", CertaintyText(part), part.why});
    if (part.is_sure) continue;
    corrections +=
        Message("To correct ", part.name, ": look at ", part.look_at, "; ", part.correct, ".\n");
  }
  return TextTable({"part", "", "certainty", "why"}, rows) + corrections;
}

std::vector<std::string> UnsurePartsBeside(const std::filesystem::path& labels_file) {
  const std::filesystem::path file = labels_file.parent_path() / "quality.json";
  std::vector<std::string> unsure;
  if (!std::filesystem::is_regular_file(file)) return unsure;
  const nlohmann::json quality = config::ReadJson(file);
  const bool is_ours =
      quality.is_object() && quality.value("format", "") == "acus-segmentation-quality/1";
  if (!is_ours || !quality.contains("parts")) return unsure;
  for (const auto& part : quality.at("parts")) {
    if (part.at("sure").get<bool>() || !part.at("in_labels").get<bool>()) continue;
    unsure.push_back(
        Message(part.at("name").get<std::string>(), " (", part.at("why").get<std::string>(),
                part.contains("certainty") && part.at("certainty").is_number()
                    ? Message("; certainty ",
                              FixedText(100.0 * part.at("certainty").get<double>(), 0), " %")
                    : "",
                ")"));
  }
  return unsure;
}

}  // namespace acus::segmentation
