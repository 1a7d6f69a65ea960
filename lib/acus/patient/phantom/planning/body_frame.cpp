#include "acus/patient/phantom/planning/body_frame.h"

#include <cmath>

#include "acus/data/volume/labels.h"

namespace acus::phantom {
namespace {

constexpr double kBinMm = 5.0;

struct MeanOf {
  double sum = 0.0;
  std::size_t count = 0;

  void Add(double value) {
    sum += value;
    ++count;
  }
  double value() const { return sum / static_cast<double>(count); }
};

}  // namespace

BodyFrame::BodyFrame(const volume::LabelMap& labels) {
  static const volume::Label kCanal = volume::LabelOf("spinal_canal");
  static const volume::Label kBone = volume::LabelOf("bone");
  static const volume::Label kLung = volume::LabelOf("lung");
  const volume::Geometry& g = labels.geometry;
  const Eigen::Affine3d ct_from_index = g.ct_from_index();
  MeanOf bone, body;
  std::map<int, MeanOf> canal;
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        const volume::Label label = labels.At(i, j, k);
        if (label == 0) continue;
        const Eigen::Vector3d p = ct_from_index * Eigen::Vector3d(i, j, k);
        body.Add(p.x());
        if (label == kBone) bone.Add(p.x());
        if (label == kCanal) canal[BinOf(p.z())].Add(p.x());
        if (label != kLung) continue;
        const auto [lung, is_first] = lung_x_mm_.try_emplace(BinOf(p.z()), Extent{p.x(), p.x()});
        lung->second.low_mm = std::min(lung->second.low_mm, p.x());
        lung->second.high_mm = std::max(lung->second.high_mm, p.x());
      }
    }
  }
  if (body.count > 0) other_middle_x_mm_ = (bone.count > 0 ? bone : body).value();
  for (const auto& [bin, mean] : canal) canal_x_mm_[bin] = mean.value();
  for (const auto& [bin, lung] : lung_x_mm_) {
    const bool is_wider =
        lung.high_mm - lung.low_mm > widest_lung_x_mm_.high_mm - widest_lung_x_mm_.low_mm;
    if (is_wider) widest_lung_x_mm_ = lung;
  }
}

int BodyFrame::BinOf(double z_mm) const {
  return static_cast<int>(std::floor(z_mm / kBinMm));
}

double BodyFrame::MiddleXMm(double z_mm) const {
  if (canal_x_mm_.empty()) return other_middle_x_mm_;
  const int bin = BinOf(z_mm);
  const auto above = canal_x_mm_.lower_bound(bin);
  if (above == canal_x_mm_.begin()) return above->second;
  const auto below = std::prev(above);
  if (above == canal_x_mm_.end()) return below->second;
  return above->first - bin < bin - below->first ? above->second : below->second;
}

double BodyFrame::Side(const Eigen::Vector3d& p) const {
  return p.x() < MiddleXMm(p.z()) ? -1.0 : 1.0;
}

bool BodyFrame::IsTrunk(const Eigen::Vector3d& p) const {
  if (lung_x_mm_.empty()) return true;
  const int bin = BinOf(p.z());
  if (bin > lung_x_mm_.rbegin()->first) return false;
  const auto lung = lung_x_mm_.lower_bound(bin);
  const Extent& width = bin < lung_x_mm_.begin()->first ? widest_lung_x_mm_ : lung->second;
  return p.x() > width.low_mm && p.x() < width.high_mm;
}

bool BodyFrame::HasLungAt(double z_mm) const {
  return lung_x_mm_.contains(BinOf(z_mm));
}

}  // namespace acus::phantom
