#include "benchmarks/bumpy_balls.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "acus/base/core/cpu_time.h"
#include "acus/data/volume/labels.h"
#include "acus/imaging/slicing/ct_sampler.h"
#include "acus/imaging/slicing/tracing/beam_labels.h"
#include "acus/patient/segmentation/voxels/rasterise.h"
#include "support/icosphere.h"

namespace acus::benchmarks {
namespace {

struct BallLayer {
  const char* tissue;
  double radius_mm;
};
constexpr std::array<BallLayer, BumpyBalls::kNumLayers> kBallLayers = {{{"skin", 80.0},
                                                                        {"fat", 78.0},
                                                                        {"muscle", 68.0},
                                                                        {"bursa", 46.0},
                                                                        {"tendon", 43.0},
                                                                        {"bone", 38.0}}};
/// Samples between two pixels of a line, to find where boundaries are.
constexpr int kFiner = 8;

/// Bumps of 2 % and folds of 0.5 %, deeper ones in each layer farther in.
double BallRadiusMm(int layer, const Eigen::Vector3d& u) {
  const double phase = 0.3 * layer;
  return kBallLayers[static_cast<std::size_t>(layer)].radius_mm *
         (1.0 + 0.02 * std::sin(7.0 * u[0] + phase) * std::cos(6.0 * u[1]) +
          0.005 * std::sin(31.0 * u[2] + phase) * std::sin(27.0 * u[0]));
}

volume::Label LabelOfLayer(int layer) {
  return volume::LabelOf(kBallLayers[static_cast<std::size_t>(layer)].tissue);
}

/// Labels by line and sample.
struct LineLabels {
  int lines = 0;
  int samples = 0;
  double step_mm = 0.0;
  std::vector<volume::Label> label;

  const volume::Label* Line(int l) const {
    return label.data() + static_cast<std::ptrdiff_t>(l) * samples;
  }
};

using FillLabels = std::function<void(const slicing::BeamLines&, const slicing::BeamBend&,
                                      const Eigen::Affine3d& ct_from_index, slicing::BeamImage&)>;

/// Where images look, with `finer` samples for each of theirs.
LineLabels LabelsAlongLines(const slicing::RestMap* rest, int finer, const FillLabels& fill) {
  acoustics::ScanGrid grid = acoustics::ScanGridOf(BumpyBalls::Probe());
  grid.samples = (grid.samples - 1) * finer + 1;
  grid.step_mm /= finer;
  // Indices of 0.5 mm, near the middle of the scene: rounding is that of images.
  const Eigen::Affine3d ct_from_index = Eigen::Translation3d(-90, -90, -90) * Eigen::Scaling(0.5);
  const Eigen::Affine3d index_from_ct = ct_from_index.inverse();
  slicing::BeamLines lines;
  slicing::PlaceLines(grid, index_from_ct, BumpyBalls::CtFromProbe(), lines);
  slicing::BeamBend bend;
  bend.Set(grid, BumpyBalls::CtFromProbe(), index_from_ct, rest);
  slicing::BeamImage label;
  label.Resize(grid.lines(), grid.samples);
  fill(lines, bend, ct_from_index, label);
  LineLabels out{grid.lines(), grid.samples, grid.step_mm, {}};
  for (int l = 0; l < out.lines; ++l) {
    for (int k = 0; k < out.samples; ++k) {
      out.label.push_back(static_cast<volume::Label>(label.row(k)[l]));
    }
  }
  return out;
}

/// Fills sample by sample from a function of the place at rest.
FillLabels FillEachSample(const std::function<volume::Label(const Eigen::Vector3d&)>& label_at) {
  return [label_at](const slicing::BeamLines& lines, const slicing::BeamBend& bend,
                    const Eigen::Affine3d& ct_from_index, slicing::BeamImage& label) {
    slicing::BeamBend::Row row;
    for (int k = 0; k < label.samples(); ++k) {
      for (int first = 0; first < label.lines(); first += 16) {
        float sample = 0.0F;
        const auto placed = bend.PlaceRow(lines, k, first, 16, row, sample);
        for (int l = 0; l < std::min(16, label.lines() - first); ++l) {
          Eigen::Vector3d index;
          for (int a = 0; a < 3; ++a) index[a] = placed.start[a][l] + sample * placed.step[a][l];
          label.row(k)[first + l] = static_cast<float>(label_at(ct_from_index * index));
        }
      }
    }
  };
}

LabelErrors BallErrorsOf(const slicing::RestMap* rest, const FillLabels& fill) {
  const FillLabels truth = FillEachSample(BumpyBalls::LabelAt);
  LabelErrors out;
  {
    const LineLabels exact = LabelsAlongLines(rest, 1, truth);
    const LineLabels found = LabelsAlongLines(rest, 1, fill);
    std::size_t wrong = 0;
    for (std::size_t n = 0; n < exact.label.size(); ++n) {
      wrong += exact.label[n] != found.label[n] ? 1 : 0;
    }
    out.wrong_percent =
        100.0 * static_cast<double>(wrong) / static_cast<double>(exact.label.size());
  }
  const LineLabels exact = LabelsAlongLines(rest, kFiner, truth);
  const LineLabels found = LabelsAlongLines(rest, kFiner, fill);
  const auto boundaries = [](const LineLabels& labels, int line) {
    std::vector<std::pair<int, volume::Label>> at;
    const volume::Label* label = labels.Line(line);
    for (int k = 1; k < labels.samples; ++k) {
      if (label[k] != label[k - 1]) at.emplace_back(k, label[k]);
    }
    return at;
  };
  double sum = 0.0;
  int count = 0, lost = 0;
  for (int l = 0; l < exact.lines; ++l) {
    const auto a = boundaries(exact, l), b = boundaries(found, l);
    const bool same =
        std::ranges::equal(a, b, [](const auto& x, const auto& y) { return x.second == y.second; });
    lost += same ? 0 : 1;
    for (std::size_t n = 0; same && n < a.size(); ++n) {
      const double off_mm = std::abs(a[n].first - b[n].first) * exact.step_mm;
      sum += off_mm * off_mm;
      out.most_mm = std::max(out.most_mm, off_mm);
      ++count;
    }
  }
  out.rms_mm = std::sqrt(sum / std::max(1, count));
  out.lost_percent = 100.0 * lost / exact.lines;
  return out;
}

}  // namespace

volume::Label BumpyBalls::LabelAt(const Eigen::Vector3d& place_mm) {
  const double r = place_mm.norm();
  const Eigen::Vector3d u = place_mm / std::max(r, 1e-9);
  for (int layer = kNumLayers; layer-- > 0;) {
    if (r < BallRadiusMm(layer, u)) return LabelOfLayer(layer);
  }
  return 0;
}

std::vector<tracing::LabelledSurface> BumpyBalls::Surfaces(int levels) {
  const mesh::Surface unit = testing_support::Icosphere(1.0, levels);
  std::vector<tracing::LabelledSurface> out;
  for (int layer = 0; layer < kNumLayers; ++layer) {
    mesh::Surface surface = unit;
    for (Eigen::Index n = 0; n < surface.nodes_mm.cols(); ++n) {
      surface.nodes_mm.col(n) *= BallRadiusMm(layer, unit.nodes_mm.col(n));
    }
    out.push_back({std::move(surface), mesh::Winding::kOriented, LabelOfLayer(layer)});
  }
  return out;
}

volume::LabelMap BumpyBalls::Voxels(const std::vector<tracing::LabelledSurface>& surfaces,
                                    double spacing_mm, double& fill_s) {
  const double half_mm = 84.0;
  volume::Geometry g;
  g.size.setConstant(static_cast<int>(2.0 * half_mm / spacing_mm) + 1);
  g.spacing_mm.setConstant(spacing_mm);
  g.origin_mm.setConstant(-half_mm + 0.137);  // Not on any symmetry.
  volume::LabelMap labels(g);
  const double begin_s = ThreadCpuSeconds();
  for (const tracing::LabelledSurface& s : surfaces) {
    segmentation::PaintInside(s.surface, s.winding, s.label, 1, labels);
  }
  fill_s = ThreadCpuSeconds() - begin_s;
  for (int layer = 0; layer < kNumLayers; ++layer) {
    labels.names[LabelOfLayer(layer)] = kBallLayers[static_cast<std::size_t>(layer)].tissue;
  }
  return labels;
}

acoustics::Probe BumpyBalls::Probe() {
  return {.name = "linear",
          .kind = acoustics::ProbeKind::kLinear,
          .frequency_mhz = 7,
          .width_mm = 40,
          .depth_mm = 50,
          .image_width_px = 512,
          .image_height_px = 512,
          .slice_thickness_mm = 3,
          .dynamic_range_db = 60};
}

Eigen::Isometry3d BumpyBalls::CtFromProbe() {
  const Eigen::Vector3d outwards = Eigen::Vector3d(0.5, 0.7, 0.6).normalized();
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear().col(1) = -outwards;
  pose.linear().col(0) = outwards.unitOrthogonal();
  pose.linear().col(2) = pose.linear().col(0).cross(pose.linear().col(1));
  pose.translation() = 79.0 * outwards;
  return pose;
}

Eigen::Vector3d TakenAlong::RestInCtMm(const Eigen::Vector3d& place_in_ct_mm,
                                       const Eigen::Vector3d&) const noexcept {
  static const Eigen::Isometry3d kCtFromProbe = BumpyBalls::CtFromProbe();
  // Slanted in the plane of the image.
  const Eigen::Vector3d axis = kCtFromProbe.linear() * Eigen::Vector3d(0.6, 0.8, 0.0);
  const Eigen::Vector3d off = place_in_ct_mm - kCtFromProbe.translation();
  const double r = (off - axis.dot(off) * axis).norm() / 20.0;
  if (r >= 1.0) return place_in_ct_mm;
  return place_in_ct_mm - 3.0 * (1.0 - r * r) * (1.0 - r * r) * axis;
}

LabelErrors ErrorsOfVoxels(const volume::LabelMap& labels, const slicing::RestMap* rest) {
  const Eigen::Affine3d index_from_ct = labels.geometry.index_from_ct();
  return BallErrorsOf(rest, FillEachSample([&](const Eigen::Vector3d& place) {
                        const Eigen::Array3d at = (index_from_ct * place).array().round();
                        if ((at < 0.0).any() || (at >= labels.geometry.size.cast<double>()).any()) {
                          return volume::Label{0};
                        }
                        const Eigen::Array3i voxel = at.cast<int>();
                        return labels.At(voxel[0], voxel[1], voxel[2]);
                      }));
}

LabelErrors ErrorsOfTriangles(const tracing::SurfaceTracer& tracer, const slicing::RestMap* rest) {
  return BallErrorsOf(rest, [&](const slicing::BeamLines& lines, const slicing::BeamBend& bend,
                                const Eigen::Affine3d& ct_from_index, slicing::BeamImage& label) {
    tracing::BeamLabels(tracer, ct_from_index).Fill(lines, bend, 1, label);
  });
}

}  // namespace acus::benchmarks
