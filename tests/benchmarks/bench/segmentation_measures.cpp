// What a segmentation is worth: tables in Markdown for docs/models/segmentation.md, from labelled
// CTs and transformed copies of them.
#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <iostream>
#include <map>
#include <numbers>
#include <optional>

#include "acus/base/config/json_file.h"
#include "acus/base/core/run_main.h"
#include "acus/base/core/text_table.h"
#include "acus/data/volume/labels.h"
#include "acus/data/volume/volume_io.h"
#include "acus/patient/atlas/atlas_organs.h"
#include "acus/patient/phantom/anatomy/imaging.h"
#include "acus/patient/phantom/anatomy/phantom_config.h"
#include "acus/patient/segmentation/import/label_mapping.h"
#include "acus/patient/segmentation/patient_segmentation.h"
#include "acus/patient/segmentation/preview.h"
#include "acus/patient/segmentation/voxels/metrics.h"
#include "support/shared_data.h"
#include "support/transformed_ct.h"

namespace acus::benchmarks {
namespace {

using segmentation::Mask;
using segmentation::MaskOf;
using testing_support::LabelledCt;

constexpr double kRightDice = 0.8;  ///< An organ that is found so well counts as right.
constexpr std::int32_t kCanal =
    10000;  ///< Added to the value where the canal of the CT as it is lies.

struct Patient {
  std::string name;
  LabelledCt whole;  ///< On a grid that takes seconds.
  segmentation::LabelMapping mapping;
  /// Number (C1 is 0) of a vertebra by its value; empty if the reference has none.
  std::map<std::int32_t, int> vertebrae;
};

struct Copy {
  std::string name;
  LabelledCt ct;
};

/// The middle of the back: 160 mm wide, to the back of the volume.
LabelledCt SpineField(const LabelledCt& from) {
  const volume::Geometry& g = from.ct.geometry;
  const int half = static_cast<int>(80.0 / g.spacing_mm[0]);
  const int depth = static_cast<int>(150.0 / g.spacing_mm[1]);
  int back = 0;  // The last row with tissue.
  for (int j = 0; j < g.size[1]; ++j) {
    if (from.ct.At(g.size[0] / 2, j, g.size[2] / 2) > -300) back = j;
  }
  return testing_support::CutTo(from, {g.size[0] / 2 - half, back - depth, 0},
                                {g.size[0] / 2 + half, back, g.size[2] - 1});
}

/// A value beyond the circle that fits into the slices.
LabelledCt Padded(LabelledCt from, std::int16_t hu) {
  const volume::Geometry& g = from.ct.geometry;
  const double radius_mm = 0.5 * std::min(g.size[0] * g.spacing_mm[0], g.size[1] * g.spacing_mm[1]);
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        const double x = (i - 0.5 * g.size[0]) * g.spacing_mm[0];
        const double y = (j - 0.5 * g.size[1]) * g.spacing_mm[1];
        if (std::hypot(x, y) > radius_mm) from.ct.At(i, j, k) = hu;
      }
    }
  }
  return from;
}

std::vector<Copy> CopiesOf(const LabelledCt& whole) {
  using namespace testing_support;
  constexpr double kRad = std::numbers::pi / 180.0;
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(),
                        z = Eigen::Vector3d::UnitZ();
  const Eigen::Array3i last = whole.ct.geometry.size - 1;
  const double slice_mm = whole.ct.geometry.spacing_mm[2];
  std::vector<Copy> copies;
  copies.push_back({"as it is", whole});
  copies.push_back({"rolled by 15 degrees", Turned(whole, z, 15 * kRad)});
  copies.push_back({"rolled by -15 degrees", Turned(whole, z, -15 * kRad)});
  copies.push_back({"tilted by 10 degrees", Turned(whole, x, 10 * kRad)});
  copies.push_back({"tilted by -10 degrees", Turned(whole, x, -10 * kRad)});
  copies.push_back({"leaning by 8 degrees", Turned(whole, y, 8 * kRad)});
  copies.push_back({"upper 60 %", CutTo(whole, {0, 0, static_cast<int>(0.4 * last[2])}, last)});
  copies.push_back({"lower 60 %", CutTo(whole, Eigen::Array3i::Zero(),
                                        {last[0], last[1], static_cast<int>(0.6 * last[2])})});
  copies.push_back({"field of view of a spine", SpineField(whole)});
  for (const double thick_mm : {3.0, 5.0}) {
    const auto count = static_cast<int>(std::lround(thick_mm / slice_mm));
    if (count < 2) continue;
    copies.push_back(
        {Message("slices of ", FixedText(count * slice_mm, 1), " mm"), Thickened(whole, count)});
  }
  copies.push_back({"noise of 20 HU more", Noisy(whole, 20.0)});
  copies.push_back({"noise of 45 HU more", Noisy(whole, 45.0)});
  copies.push_back({"padding of -2048 HU", Padded(whole, -2048)});
  copies.push_back({"padding of 0 HU", Padded(whole, 0)});
  return copies;
}

Mask Reference(const Patient& patient, const LabelledCt& copy, const std::string& tissue) {
  Mask mask(copy.labels.geometry);
  for (std::size_t n = 0; n < mask.voxels.size(); ++n) {
    const auto found = patient.mapping.tissue.find(copy.labels.voxels[n] % kCanal);
    const bool is_it =
        found != patient.mapping.tissue.end() && found->second == volume::LabelOf(tissue);
    mask.voxels[n] = is_it ? 1 : 0;
  }
  return mask;
}

Mask Canal(const LabelledCt& copy) {
  Mask mask(copy.labels.geometry);
  for (std::size_t n = 0; n < mask.voxels.size(); ++n) {
    mask.voxels[n] = copy.labels.voxels[n] >= kCanal ? 1 : 0;
  }
  return mask;
}

std::string Agreement(const Mask& ours, const Mask& theirs, int num_threads) {
  if (segmentation::Count(ours) == 0 || segmentation::Count(theirs) == 0) return "-";
  return Message(FixedText(segmentation::Dice(ours, theirs), 3), " (",
                 FixedText(segmentation::SurfaceDistance95Mm(ours, theirs, num_threads), 1), ")");
}

/// A part that was found, with a reference.
struct Case {
  std::string part;
  bool has_doubt, is_right;
  bool is_held_back;  ///< Not used for the certainty that is stated.
};

void AddCase(const segmentation::SegmentedPatient& found, const std::string& part,
             const Mask& theirs, bool is_held_back, std::vector<Case>& cases) {
  const Mask ours = MaskOf(found.labels, volume::LabelOf(part));
  if (segmentation::Count(ours) == 0 || segmentation::Count(theirs) == 0) return;
  const auto stated = std::ranges::find(found.parts, part, &segmentation::PartQuality::name);
  if (stated == found.parts.end()) return;
  cases.push_back(
      {part, !stated->is_sure, segmentation::Dice(ours, theirs) >= kRightDice, is_held_back});
}

/// What is stated for a part with and without doubts, and how often it is right in the other half.
void PrintCertainty(const std::vector<Case>& cases) {
  std::cout << "\n| part | doubts | right, half used | certainty | right, half held back |\n"
               "|---|---|---|---|---|\n";
  for (const char* part : {"bone", "spinal_canal", "disc"}) {
    for (const bool has_doubt : {false, true}) {
      std::array<int, 2> right{}, all{};
      for (const Case& one : cases) {
        if (one.part != part || one.has_doubt != has_doubt) continue;
        const std::size_t half = one.is_held_back ? 1 : 0;
        ++all[half];
        right[half] += one.is_right ? 1 : 0;
      }
      std::cout << Message("| ", part, " | ", has_doubt ? "some" : "none", " | ", right[0], " of ",
                           all[0], " | ", FixedText((right[0] + 1.0) / (all[0] + 2.0), 2), " | ",
                           right[1], " of ", all[1], " |\n");
    }
  }
}

struct Names {
  int right = 0, wrong = 0, unnamed = 0;
};

Names NamesIn(const Patient& patient, const LabelledCt& copy,
              const segmentation::Vertebrae& vertebrae) {
  Names names;
  for (std::size_t n = 0; n < vertebrae.list.size(); ++n) {
    const auto number = segmentation::NumberOfVertebra(vertebrae.list[n].name);
    if (!number) {
      ++names.unnamed;
      continue;
    }
    std::map<int, int> votes;
    for (std::size_t at = 0; at < copy.labels.voxels.size(); ++at) {
      if (vertebrae.labels.voxels[at] != n + 1) continue;
      const auto value = patient.vertebrae.find(copy.labels.voxels[at] % kCanal);
      if (value != patient.vertebrae.end()) ++votes[value->second];
    }
    const auto most = std::ranges::max_element(votes, {}, [](const auto& v) { return v.second; });
    ++(most != votes.end() && most->first == *number ? names.right : names.wrong);
  }
  return names;
}

/// The share of what lies within 2 mm around the canal, %; "-" where voxels are wider than that.
std::string MuscleAround(const volume::LabelMap& labels, int num_threads) {
  const Mask canal = MaskOf(labels, volume::LabelOf("spinal_canal"));
  const Mask wide = segmentation::Dilated(canal, 2.0, num_threads);
  double ring = 0.0, muscle = 0.0;
  for (std::size_t n = 0; n < wide.voxels.size(); ++n) {
    if (wide.voxels[n] == 0 || canal.voxels[n] != 0) continue;
    ++ring;
    muscle += labels.voxels[n] == volume::LabelOf("muscle") ? 1.0 : 0.0;
  }
  return ring > 0.0 ? FixedText(100.0 * muscle / ring, 1) : "-";
}

segmentation::SegmentedPatient Segmented(const volume::CtVolume& ct, const RunContext& context) {
  const auto config =
      segmentation::ReadSegmentationConfig(config::FindConfig("segmentation/default.json", "."));
  auto found = segmentation::SegmentPatient(ct, config, context);
  return segmentation::Examine(ct, config, std::move(found), {}, context);
}

void Print(const std::vector<std::string>& cells) {
  for (const std::string& cell : cells) std::cout << "| " << cell << ' ';
  std::cout << "|" << std::endl;
}

/// Three images, the sagittal one through the canal, named after the patient and the copy.
void Draw(const std::filesystem::path& folder, const std::string& name, const Copy& copy,
          const volume::LabelMap& labels) {
  if (folder.empty()) return;
  using segmentation::Plane;
  Eigen::Array3i at = segmentation::BodyCentre(labels);
  const auto box = segmentation::BoundsOf(MaskOf(labels, volume::LabelOf("spinal_canal")));
  if (!box.empty()) at[0] = (box.low[0] + box.high[0]) / 2;
  std::string stem = name + "_" + copy.name;
  std::ranges::replace(stem, ' ', '_');
  for (const auto& [plane, text] : {std::pair{Plane::kAxial, "_axial.png"},
                                    {Plane::kCoronal, "_coronal.png"},
                                    {Plane::kSagittal, "_sagittal.png"}}) {
    segmentation::WritePreview(folder / (stem + text), copy.ct.ct, labels, plane, at);
  }
}

/// Bone, lung, canal and names in all copies of a patient.
void MeasureTissues(Patient& patient, const std::filesystem::path& images, Names& all,
                    std::vector<Case>& cases, const RunContext& context) {
  const auto as_it_is = Segmented(patient.whole.ct, context);
  for (std::size_t n = 0; n < as_it_is.labels.voxels.size(); ++n) {
    if (as_it_is.labels.voxels[n] == volume::LabelOf("spinal_canal")) {
      patient.whole.labels.voxels[n] += kCanal;
    }
  }
  bool is_held_back = true;
  for (const Copy& copy : CopiesOf(patient.whole)) {
    is_held_back = !is_held_back;
    const auto found = Segmented(copy.ct.ct, context);
    AddCase(found, "bone", Reference(patient, copy.ct, "bone"), is_held_back, cases);
    AddCase(found, "spinal_canal", Canal(copy.ct), is_held_back, cases);
    Draw(images, patient.name, copy, found.labels);
    const auto agreement = [&](const char* tissue) {
      return Agreement(MaskOf(found.labels, volume::LabelOf(tissue)),
                       Reference(patient, copy.ct, tissue), context.num_threads);
    };
    std::string names = "no reference";
    if (!patient.vertebrae.empty()) {
      const Names here = NamesIn(patient, copy.ct, found.vertebrae);
      names = Message(here.right, " / ", here.unnamed, " / ", here.wrong);
      all.right += here.right;
      all.unnamed += here.unnamed;
      all.wrong += here.wrong;
    }
    Print({patient.name, copy.name, agreement("bone"), agreement("lung"),
           Agreement(MaskOf(found.labels, volume::LabelOf("spinal_canal")), Canal(copy.ct),
                     context.num_threads),
           MuscleAround(found.labels, context.num_threads), names});
  }
}

/// Synthetic patients, whose labels are exact: odd seeds for the certainty, even ones held back.
void MeasurePhantoms(std::vector<Case>& cases, RunContext& context) {
  auto config = phantom::ReadPhantomConfig(config::FindConfig("phantoms/lumbar.json", "."));
  config.grid.origin_mm = Eigen::Vector3d(-75, -60, -108);
  config.grid.size = {151, 146, 116};
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    context.seed = seed;
    const phantom::Anatomy anatomy(config.body, seed);
    const phantom::Scan scan = phantom::RenderScan(anatomy, config.grid, config.scanner, context);
    LabelledCt whole{scan.ct, volume::Grid<std::int32_t>(scan.ct.geometry)};
    std::ranges::copy(scan.labels.voxels, whole.labels.voxels.begin());
    using namespace testing_support;
    for (const LabelledCt& copy : {whole, Turned(whole, Eigen::Vector3d::UnitZ(), 0.25),
                                   Thickened(whole, 3), Thickened(whole, 5), Noisy(whole, 45.0)}) {
      const auto found = Segmented(copy.ct, context);
      for (const char* part : {"bone", "spinal_canal", "disc"}) {
        Mask theirs(copy.labels.geometry);
        for (std::size_t n = 0; n < theirs.voxels.size(); ++n) {
          theirs.voxels[n] = copy.labels.voxels[n] == volume::LabelOf(part) ? 1 : 0;
        }
        AddCase(found, part, theirs, seed % 2 == 0, cases);
      }
    }
  }
}

/// Dice of each part of an organ that a reference has too.
std::map<std::string, double> DiceOfParts(const std::string& organ, const volume::LabelMap& found,
                                          const Mask& theirs) {
  const auto middle = segmentation::MiddleXMm(found);
  const auto ours = segmentation::OrganParts(organ, MaskOf(found, volume::LabelOf(organ)), middle);
  std::map<std::string, double> dice;
  for (const auto& [name, mask] : ours) {
    dice[name] = 0.0;
    for (const auto& [other, reference] : segmentation::OrganParts(organ, theirs, middle)) {
      if (other == name) dice[name] = segmentation::Dice(mask, reference);
    }
  }
  return dice;
}

/// One line for each organ: where it comes from, its Dice, the evidence, and what speaks against
/// it (without the evidence).
void WriteOrganCases(std::ostream& out, const Patient& patient, const Copy& copy,
                     const std::string& atlas, const volume::LabelMap& found,
                     const std::vector<segmentation::OrganEvidence>& evidence) {
  const auto checks = segmentation::CheckOrgans(found);
  for (const char* organ : {"liver", "kidney", "spleen"}) {
    const Mask theirs = Reference(patient, copy.ct, organ);
    if (segmentation::Count(theirs) == 0) continue;
    const auto dice = DiceOfParts(organ, found, theirs);
    for (const auto& e : evidence) {
      if (!dice.contains(e.name)) continue;
      const auto check = std::ranges::find(checks, e.name, &segmentation::OrganCheck::name);
      const std::size_t doubts = check == checks.end() ? 0 : check->doubts.size();
      out << patient.name << ',' << copy.name << ',' << atlas << ',' << e.name << ',' << doubts;
      for (const double value : {dice.at(e.name), e.edge_share, e.barred_share, e.covered_share}) {
        out << ',' << FixedText(value, 3);
      }
      out << std::endl;
    }
  }
}

/// All that an atlas patient says, moved by voxels of the coarse grid: organs in wrong places.
atlas::CarriedLabels Displaced(const atlas::CarriedLabels& carried, const Eigen::Array3i& by) {
  atlas::CarriedLabels out = carried;
  const Eigen::Array3i& size = carried.organs.geometry.size;
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        const Eigen::Array3i at = Eigen::Array3i(i, j, k) - by;
        const bool is_in = carried.organs.geometry.Contains(at[0], at[1], at[2]);
        out.organs.At(i, j, k) = is_in ? carried.organs.At(at[0], at[1], at[2]) : 0;
        out.aligned.At(i, j, k) = is_in ? carried.aligned.At(at[0], at[1], at[2]) : 0;
      }
    }
  }
  return out;
}

/// Copies that change what an organ looks like or how much of it is seen.
bool IsForOrgans(const std::string& copy) {
  static const std::array kNames = {"as it is", "rolled by 15", "upper",
                                    "lower",    "slices",       "noise of 45"};
  return std::ranges::any_of(kNames, [&](const char* name) { return copy.starts_with(name); });
}

/// Organs of one patient by the labels of others, in places that are right and wrong; in copies by
/// the labels of the first other.
void MeasureOrgans(const Patient& patient, const std::vector<atlas::LabelledPatient>& others,
                   const RunContext& context) {
  const auto config =
      segmentation::ReadSegmentationConfig(config::FindConfig("segmentation/default.json", "."));
  const std::vector<Eigen::Array3i> none = {{0, 0, 0}};
  const std::vector<Eigen::Array3i> moves = {
      {0, 0, 0}, {0, 0, 9}, {0, 0, -8}, {7, 0, 0}, {-4, 5, 0}};
  for (const Copy& copy : CopiesOf(patient.whole)) {
    if (!IsForOrgans(copy.name)) continue;
    const bool is_whole = copy.name == "as it is";
    const auto tissues = segmentation::SegmentPatient(copy.ct.ct, config, context).labels;
    const atlas::PatientImage image(copy.ct.ct, tissues, atlas::kAtlasSpacingMm);
    for (const atlas::LabelledPatient& other : others) {
      const auto carried = atlas::CarryLabels(other, image, context);
      if (!carried) continue;
      const bool is_first = &other == &others.front();
      for (const Eigen::Array3i& by : is_whole&& is_first ? moves : none) {
        auto labels = tissues;
        std::vector<segmentation::OrganEvidence> evidence;
        try {
          evidence = atlas::AddCarriedOrgans(image, {Displaced(*carried, by)}, labels, context);
        } catch (const NoAnswerError&) {
          continue;
        }
        const std::string moved =
            Message(other.name, " moved by ", 3 * by[0], " ", 3 * by[1], " ", 3 * by[2]);
        WriteOrganCases(std::cout, patient, copy, moved, labels, evidence);
      }
      if (!is_whole) break;
    }
  }
}

/// A patient as an atlas patient, on the grid that takes seconds.
atlas::LabelledPatient AsAtlas(const Patient& patient, const RunContext& context) {
  const auto config =
      segmentation::ReadSegmentationConfig(config::FindConfig("segmentation/default.json", "."));
  atlas::LabelledPatient out{.name = patient.name,
                             .ct = patient.whole.ct,
                             .tissues = {},
                             .organs = volume::LabelMap(patient.whole.ct.geometry)};
  for (std::size_t n = 0; n < out.organs.voxels.size(); ++n) {
    const auto tissue = patient.mapping.tissue.find(patient.whole.labels.voxels[n]);
    if (tissue != patient.mapping.tissue.end()) out.organs.voxels[n] = tissue->second;
  }
  out.tissues = segmentation::FindTissues(out.ct, config.tissues, context).labels;
  return out;
}

/// A synthetic patient as an atlas patient: unlike a real one, so that its organs often end wrong.
atlas::LabelledPatient SyntheticAtlas(std::uint64_t seed, RunContext& context) {
  auto config = phantom::ReadPhantomConfig(config::FindConfig("phantoms/liver.json", "."));
  config.body.variation_percent = 8.0;
  config.grid.size = (config.grid.size.cast<double>() * config.grid.spacing_mm / 3.0).cast<int>();
  config.grid.spacing_mm = Eigen::Array3d::Constant(3.0);
  context.seed = seed;
  phantom::Scan scan = phantom::RenderScan(phantom::Anatomy(config.body, seed), config.grid,
                                           config.scanner, context);
  const auto settings =
      segmentation::ReadSegmentationConfig(config::FindConfig("segmentation/default.json", "."));
  atlas::LabelledPatient out{.name = Message("synthetic ", seed),
                             .ct = std::move(scan.ct),
                             .tissues = {},
                             .organs = std::move(scan.labels)};
  out.tissues = segmentation::FindTissues(out.ct, settings.tissues, context).labels;
  return out;
}

std::optional<Patient> Read(const std::string& name, const std::string& ct,
                            const std::string& labels, const std::string& mapping, int coarser,
                            const RunContext& context) {
  const auto ct_path = testing_support::SharedData(ct.c_str());
  const auto labels_path = testing_support::SharedData(labels.c_str());
  if (!ct_path || !labels_path) {
    context.Warn(Message(name, " is not here: skipped"));
    return std::nullopt;
  }
  const auto table = config::FindConfig("label_maps/" + mapping, ".");
  LabelledCt whole{volume::ReadCt(*ct_path, "", context), volume::ReadIntegerVolume(*labels_path)};
  if (coarser > 1) whole = testing_support::Coarsened(whole, coarser);
  return Patient{.name = name,
                 .whole = std::move(whole),
                 .mapping = segmentation::ReadLabelMapping(table),
                 .vertebrae = {}};
}

}  // namespace
}  // namespace acus::benchmarks

int main(int argc, char** argv) {
  using namespace acus::benchmarks;
  bool with_organs = false;
  std::string only;
  std::filesystem::path images;
  CLI::App app{"Tables of what a segmentation is worth, on labelled CTs and transformed copies.",
               "segmentation_measures"};
  app.footer("EXAMPLE\n  build/tests/segmentation_measures --organs\n");
  app.add_flag("--organs", with_organs,
               "Only organs by atlases: Dice and evidence, CSV, of which "
               "testdata/organ_evidence.csv is a run");
  app.add_option("--only", only, "Only the CT with this name")
      ->check(CLI::IsMember({"totalseg example", "ircadb01"}));
  app.add_option("--images", images, "Also images of each copy, in this folder")
      ->check(CLI::ExistingDirectory);
  return acus::RunMain(app, argc, argv, [&](acus::RunContext& context) {
    auto total = Read("totalseg example", "ct/totalseg/example_ct.nii.gz",
                      "ct/totalseg/example_seg_fast_force_split.nii.gz", "totalsegmentator.json", 1,
                      context);
    auto ircad =
        Read("ircadb01", "ct/ircadb01_dicom", "ct/ircadb01_labels.vti", "ircadb.json", 2, context);
    // TotalSegmentator counts from the sacrum (25) and S1 (26) upwards.
    if (total) {
      for (std::int32_t value = 25; value <= 50; ++value) {
        total->vertebrae[value] = 24 - std::max(value - 26, 0);
      }
    }
    if (with_organs) {
      if (!total || !ircad) return acus::ExitCode::kOk;
      std::cout << "patient,copy,atlas,organ,doubts,dice,edge_share,barred_share,covered_share\n";
      const auto phantom = SyntheticAtlas(1, context);
      if (only != "ircadb01") MeasureOrgans(*total, {AsAtlas(*ircad, context), phantom}, context);
      if (only != "totalseg example") {
        MeasureOrgans(*ircad, {AsAtlas(*total, context), phantom}, context);
      }
      return acus::ExitCode::kOk;
    }
    Names names;
    std::vector<Case> cases;
    std::cout
        << "| CT | copy | bone | lung | canal, to that of the CT as it is | muscle within 2 mm "
           "of the canal, % | names right / none / wrong |\n|---|---|---|---|---|---|---|\n";
    for (auto* patient : {&total, &ircad}) {
      if (!*patient || (!only.empty() && (*patient)->name != only)) continue;
      MeasureTissues(**patient, images, names, cases, context);
    }
    std::cout << "\nNames: " << names.right << " right, " << names.unnamed << " none, "
              << names.wrong << " wrong.\n";
    if (only.empty()) {
      MeasurePhantoms(cases, context);
      PrintCertainty(cases);
    }
    return acus::ExitCode::kOk;
  });
}
