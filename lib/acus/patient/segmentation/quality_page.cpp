#include "acus/patient/segmentation/quality_page.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "acus/base/core/text_table.h"
#include "acus/base/report/html_report.h"
#include "acus/data/image/png.h"
#include "acus/data/volume/label_map_content.h"
#include "acus/data/volume/labels.h"
#include "acus/patient/segmentation/preview.h"

namespace acus::segmentation {
namespace {

constexpr double kPixelMm = 0.8;
constexpr double kAmbient = 0.25;

/// What a view shows: nothing that lies over it.
bool IsInView(volume::Label label) {
  static const std::vector<volume::Label> kHidden = [] {
    std::vector<volume::Label> hidden = {0};
    for (const char* name : {"skin", "cut", "fat", "soft_tissue", "muscle", "gas", "lung"}) {
      hidden.push_back(volume::LabelOf(name));
    }
    return hidden;
  }();
  return std::ranges::find(kHidden, label) == kHidden.end();
}

struct Hit {
  double depth_mm;
  volume::Label label;
};

/// Looks along y of the patient, parallel, onto the plane of x and z.
class Projection {
 public:
  Projection(const volume::LabelMap& labels, bool from_back)
      : labels_(labels), index_from_ct_(labels.geometry.index_from_ct()) {
    const Eigen::AlignedBox3d box =
        Eigen::AlignedBox3d(Eigen::Vector3d::Zero(),
                            (labels.geometry.size - 1).cast<double>().matrix())
            .transformed(labels.geometry.ct_from_index());
    start_ = {from_back ? box.max().x() : box.min().x(), from_back ? box.max().y() : box.min().y(),
              box.max().z()};
    // From behind, the patient's left is on the left.
    side_ = from_back ? -1.0 : 1.0;
    depth_ = box.sizes().y();
    width_ = static_cast<int>(box.sizes().x() / kPixelMm) + 1;
    height_ = static_cast<int>(box.sizes().z() / kPixelMm) + 1;
    inwards_ = from_back ? -1.0 : 1.0;
    hits_.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) At(x, y) = HitOf(x, y);
    }
  }

  void Write(const std::filesystem::path& path) {
    image::ColourImage image;
    image.Resize(width_, height_);
    std::ranges::fill(image.rgb, std::uint8_t{255});
    for (int y = 1; y + 1 < height_; ++y) {
      for (int x = 1; x + 1 < width_; ++x) {
        const auto& hit = At(x, y);
        if (!hit) continue;
        const auto colour = volume::ColourOf(hit->label);
        const double light = LightAt(x, y);
        for (std::size_t c = 0; c < 3; ++c) {
          image.rgb[3 * Place(x, y) + c] =
              static_cast<std::uint8_t>(std::lround(light * colour[c]));
        }
      }
    }
    image::WritePng(path, image);
  }

 private:
  std::size_t Place(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(x);
  }
  std::optional<Hit>& At(int x, int y) { return hits_[Place(x, y)]; }

  std::optional<Hit> HitOf(int x, int y) const {
    for (double depth = 0.0; depth <= depth_; depth += kPixelMm) {
      const Eigen::Vector3d p =
          start_ + Eigen::Vector3d(side_ * x * kPixelMm, inwards_ * depth, -y * kPixelMm);
      const Eigen::Array3i at = (index_from_ct_ * p).array().round().cast<int>();
      if (!labels_.geometry.Contains(at[0], at[1], at[2])) continue;
      const volume::Label label = labels_.At(at[0], at[1], at[2]);
      if (IsInView(label)) return Hit{depth, label};
    }
    return std::nullopt;
  }

  /// The light of a lamp beside the eye, by the slope of the depths over a few pixels.
  double LightAt(int x, int y) {
    const double here = At(x, y)->depth_mm;
    const auto depth = [&](int u, int v) {
      u = std::clamp(u, 0, width_ - 1);
      v = std::clamp(v, 0, height_ - 1);
      return At(u, v) ? std::clamp(At(u, v)->depth_mm, here - 8.0, here + 8.0) : here + 8.0;
    };
    constexpr int kReach = 2;
    const double scale = 2.0 * kReach * kPixelMm;
    const double slope_x = (depth(x + kReach, y) - depth(x - kReach, y)) / scale;
    const double slope_y = (depth(x, y + kReach) - depth(x, y - kReach)) / scale;
    const double lit = (1.0 + 0.4 * slope_x + 0.4 * slope_y) /
                       (std::sqrt(1.0 + slope_x * slope_x + slope_y * slope_y) * 1.15);
    return kAmbient + (1.0 - kAmbient) * std::clamp(lit, 0.0, 1.0);
  }

  const volume::LabelMap& labels_;
  Eigen::Affine3d index_from_ct_;
  Eigen::Vector3d start_;
  double side_, inwards_, depth_;
  int width_, height_;
  std::vector<std::optional<Hit>> hits_;
};

void AddParts(const SegmentedPatient& patient, report::HtmlReport& page) {
  page.Section("What is sure, what is not");
  std::vector<std::vector<std::string>> rows;
  for (const PartQuality& part : patient.parts) {
    rows.push_back(
        {part.name, part.is_sure ? "sure" : "unsure",
         part.certainty ? Message(FixedText(100.0 * *part.certainty, 0), " %") : "", part.why,
         part.look_at,
         part.correct.starts_with("--") ? "acus-segment " + part.correct : part.correct});
  }
  page.Table({"part", "", "certainty", "why", "look at", "to correct it"}, rows,
             Message("Sure: nothing that is checked speaks against it. Certainty: how many of such "
                     "cases had a Dice of at least 0.8 with a reference; of organs from an atlas, ",
                     kRightOrganDice));
}

void AddVolumes(const SegmentedPatient& patient, report::HtmlReport& page) {
  page.Section("Volumes");
  const auto counts = volume::CountsByLabel(patient.labels);
  const double ml = patient.labels.geometry.voxel_volume_mm3() / 1000.0;
  std::vector<std::vector<std::string>> rows;
  for (const auto& [label, name] : patient.labels.names) {
    if (label == 0 || counts[label] == 0) continue;
    rows.push_back({name, FixedText(static_cast<double>(counts[label]) * ml, 1), ""});
  }
  for (const OrganCheck& organ : patient.organs) {
    const std::string range =
        Message(FixedText(organ.least_ml, 0), " to ", FixedText(organ.most_ml, 0));
    const auto row = std::ranges::find(rows, organ.name, [](const auto& r) { return r.front(); });
    if (row != rows.end()) {
      row->back() = range;
    } else {
      rows.push_back({organ.name, FixedText(organ.volume_ml, 1), range});
    }
  }
  page.Table({"tissue", "ml", "of adults, ml"}, rows);
}

void AddVertebrae(const Vertebrae& vertebrae, report::HtmlReport& page) {
  if (vertebrae.empty()) return;
  page.Section("Vertebrae");
  std::vector<std::vector<std::string>> rows;
  for (const Vertebra& v : vertebrae.list) {
    rows.push_back({v.name, v.is_whole ? "yes" : "no", FixedText(v.volume_ml, 1),
                    Message(FixedText(v.centre_mm.x(), 1), ", ", FixedText(v.centre_mm.y(), 1),
                            ", ", FixedText(v.centre_mm.z(), 1))});
  }
  page.Table({"vertebra", "whole", "ml", "centre of its body (CT, mm)"}, rows,
             "From the head to the feet");
}

}  // namespace

void WriteViews(const std::filesystem::path& folder, const volume::LabelMap& labels) {
  Projection(labels, true).Write(folder / "view_back.png");
  Projection(labels, false).Write(folder / "view_front.png");
}

void WriteQualityPage(const std::filesystem::path& folder, const SegmentedPatient& patient,
                      const nlohmann::json& provenance) {
  const auto unsure = std::ranges::count(patient.parts, false, &PartQuality::is_sure);
  report::HtmlReport page(
      "Segmentation of a CT",
      unsure == 0 ? "Nothing that is checked speaks against it"
                  : Message(unsure, unsure == 1 ? " part is unsure" : " parts are unsure"));
  page.Warnings(patient.warnings);
  AddParts(patient, page);
  page.Section("Slices");
  for (const char* plane : {"axial", "coronal", "sagittal"}) {
    page.Image(folder / Message("preview_", plane, ".png"),
               Message("CT in the ", plane, " plane through the middle, with outlines"),
               Message("CT in the ", plane, " plane, with the outlines of the labels"));
  }
  page.Section("Bone and organs in 3D");
  page.Image(folder / "view_back.png", "bone and organs as seen from behind",
             "From behind: the patient's right is on the right");
  page.Image(folder / "view_front.png", "bone and organs as seen from the front",
             "From the front: the patient's right is on the left");
  AddVolumes(patient, page);
  AddVertebrae(patient.vertebrae, page);
  page.SetProvenance(provenance);
  page.Write(folder / "report.html");
}

}  // namespace acus::segmentation
