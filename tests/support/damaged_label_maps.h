// Label maps by seed, damaged as those of patients are: islands, walls of one voxel, holes, organs
// that touch, fields that cut the body, slices far apart.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <random>
#include <string>
#include <vector>

#include "acus/data/volume/volume.h"

namespace acus::testing_support {

/// One map and what was done to it, for messages.
struct DamagedMap {
  volume::LabelMap labels;
  std::string story;
};

class DamagedMapMaker {
 public:
  explicit DamagedMapMaker(unsigned seed) : random_(seed) {}

  DamagedMap Make() {
    MakePatient();
    using Damage = void (DamagedMapMaker::*)();
    struct Kind {
      const char* name;
      Damage damage;
    };
    constexpr std::array<Kind, 8> kKinds = {{{"islands", &DamagedMapMaker::AddIslands},
                                             {"specks", &DamagedMapMaker::AddSpecks},
                                             {"wall", &DamagedMapMaker::AddWall},
                                             {"holes", &DamagedMapMaker::AddHoles},
                                             {"touching", &DamagedMapMaker::AddTouchingOrgans},
                                             {"cut", &DamagedMapMaker::CutField},
                                             {"lost slices", &DamagedMapMaker::LoseSlices},
                                             {"thread", &DamagedMapMaker::AddThread}}};
    const int count = Whole(1, 4);
    for (int n = 0; n < count; ++n) {
      const Kind& kind = kKinds[static_cast<std::size_t>(Whole(0, 7))];
      out_.story += std::string(" ") + kind.name;
      (this->*kind.damage)();
    }
    return std::move(out_);
  }

 private:
  int Whole(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }
  double Real(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  Eigen::Array3i Voxel() {
    const Eigen::Array3i& n = out_.labels.geometry.size;
    return {Whole(0, n[0] - 1), Whole(0, n[1] - 1), Whole(0, n[2] - 1)};
  }
  std::uint8_t Tissue() { return kTissues[static_cast<std::size_t>(Whole(0, 4))]; }
  template <typename Visit>
  void ForEach(const Visit& visit) {
    volume::LabelMap& labels = out_.labels;
    for (int k = 0; k < labels.geometry.size[2]; ++k) {
      for (int j = 0; j < labels.geometry.size[1]; ++j) {
        for (int i = 0; i < labels.geometry.size[0]; ++i) visit({i, j, k}, labels.At(i, j, k));
      }
    }
  }
  /// Ellipsoid in shares of the field.
  void Fill(const Eigen::Array3d& centre, const Eigen::Array3d& half, std::uint8_t label,
            bool only_in_body) {
    const Eigen::Array3d size = out_.labels.geometry.size.cast<double>();
    ForEach([&](const Eigen::Array3i& at, std::uint8_t& voxel) {
      const Eigen::Array3d share = (at.cast<double>() + 0.5) / size;
      if (only_in_body && voxel == 0) return;
      if (((share - centre) / half).matrix().squaredNorm() < 1.0) voxel = label;
    });
  }

  /// 60 to 200 mm of a trunk with skin, bone and three organs; slices up to ten times as thick as
  /// pixels are wide.
  void MakePatient() {
    volume::Geometry geometry;
    const double pixel_mm = Real(0.7, 3.0);
    const int axis = Whole(0, 2);
    const double ratio = std::exp(Real(0.0, std::log(10.0)));
    for (int a = 0; a < 3; ++a) {
      geometry.spacing_mm[a] = a == axis ? pixel_mm * ratio : pixel_mm;
      const double extent_mm = Real(60.0, 200.0);
      geometry.size[a] = std::clamp(static_cast<int>(extent_mm / geometry.spacing_mm[a]), 8, 96);
    }
    out_.labels = volume::LabelMap(geometry);
    out_.labels.names = {{1, "skin"}, {2, "fat"}, {5, "bone"}, {8, "liver"}, {9, "kidney"}};
    out_.story = "1:" + std::to_string(ratio).substr(0, 4);
    const Eigen::Array3d middle(0.5, 0.5, 0.5);
    const Eigen::Array3d body(Real(0.35, 0.48), Real(0.35, 0.48), Real(0.4, 0.8));
    Fill(middle, body, 1, false);
    Fill(middle, 0.93 * body, 2, true);
    for (const std::uint8_t label : {std::uint8_t{5}, std::uint8_t{8}, std::uint8_t{9}}) {
      Fill({Real(0.3, 0.7), Real(0.3, 0.7), Real(0.2, 0.8)},
           {Real(0.05, 0.2), Real(0.05, 0.2), Real(0.05, 0.3)}, label, true);
    }
  }
  void AddIslands() {
    const int count = Whole(1, 6);
    for (int n = 0; n < count; ++n) {
      Fill({Real(0, 1), Real(0, 1), Real(0, 1)},
           {Real(0.01, 0.1), Real(0.01, 0.1), Real(0.01, 0.1)}, Tissue(), false);
    }
  }
  void AddSpecks() {
    const double share = std::exp(Real(std::log(1e-4), std::log(0.03)));
    ForEach([&](const Eigen::Array3i&, std::uint8_t& voxel) {
      if (Real(0, 1) < share) voxel = Whole(0, 3) == 0 ? std::uint8_t{0} : Tissue();
    });
  }
  /// One voxel thick, straight along an axis or a diagonal.
  void AddWall() {
    const int a = Whole(0, 2), b = Whole(0, 2);
    const Eigen::Array3i at = Voxel();
    const std::uint8_t label = Whole(0, 2) == 0 ? std::uint8_t{0} : Tissue();
    ForEach([&](const Eigen::Array3i& x, std::uint8_t& voxel) {
      const int distance = a == b ? x[a] - at[a] : x[a] - at[a] + x[b] - at[b];
      if (distance == 0 && voxel != 0) voxel = label;
    });
  }
  void AddHoles() {
    const int count = Whole(1, 8);
    for (int n = 0; n < count; ++n) {
      Fill({Real(0.2, 0.8), Real(0.2, 0.8), Real(0.1, 0.9)},
           {Real(0.01, 0.12), Real(0.01, 0.12), Real(0.01, 0.12)}, 0, true);
    }
  }
  void AddTouchingOrgans() {
    const Eigen::Array3d centre(Real(0.3, 0.7), Real(0.3, 0.7), Real(0.3, 0.7));
    const double radius = Real(0.06, 0.15);
    Fill(centre, Eigen::Array3d::Constant(radius), 8, true);
    Fill(centre + Eigen::Array3d(2.0 * radius, 0, 0), Eigen::Array3d::Constant(radius), 9, true);
    Fill(centre + Eigen::Array3d(radius, radius, 0), Eigen::Array3d::Constant(radius), 5, true);
  }
  void CutField() {
    const int axis = Whole(0, 2);
    const bool at_end = Whole(0, 1) == 1;
    const int size = out_.labels.geometry.size[axis];
    const int plane = static_cast<int>(Real(0.15, 0.5) * size);
    ForEach([&](const Eigen::Array3i& x, std::uint8_t& voxel) {
      if ((at_end ? size - 1 - x[axis] : x[axis]) < plane) voxel = 0;
    });
  }
  void LoseSlices() {
    const int axis = Whole(0, 2);
    const int slice = Whole(0, out_.labels.geometry.size[axis] - 1);
    ForEach([&](const Eigen::Array3i& x, std::uint8_t& voxel) {
      if (x[axis] == slice) voxel = 0;
    });
  }
  /// A vessel or bone of one voxel across that winds through the field.
  void AddThread() {
    Eigen::Array3i at = Voxel();
    const std::uint8_t label = Tissue();
    for (int n = 0; n < 150; ++n) {
      std::uint8_t& voxel = out_.labels.At(at[0], at[1], at[2]);
      if (voxel != 0) voxel = label;
      const int axis = Whole(0, 2);
      at[axis] = std::clamp(at[axis] + (Whole(0, 1) == 1 ? 1 : -1), 0,
                            out_.labels.geometry.size[axis] - 1);
    }
  }

  static constexpr std::array<std::uint8_t, 5> kTissues = {1, 2, 5, 8, 9};
  std::mt19937 random_;
  DamagedMap out_;
};

}  // namespace acus::testing_support
