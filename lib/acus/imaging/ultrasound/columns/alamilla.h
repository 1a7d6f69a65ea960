// Ultrasound-like images of labelled scenes, after Alamilla et al. 2021, section V: reflection and
// shadow from a depth map, absorption, Perlin noise for speckle, longitudinal and lateral texture
// of thick tissue, and an oriented blur along the fibres of thin tissue. Needs no CT.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "acus/data/image/image.h"
#include "acus/data/volume/volume.h"
#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/slicing/beam_bend.h"
#include "acus/imaging/slicing/ct_sampler.h"
#include "acus/imaging/slicing/tracing/beam_labels.h"
#include "acus/imaging/ultrasound/columns/alamilla_options.h"
#include "acus/imaging/ultrasound/columns/example_texture.h"
#include "acus/imaging/ultrasound/columns/fibre_field.h"
#include "acus/imaging/ultrasound/columns/pixel_shift.h"
#include "acus/imaging/ultrasound/display/scan_conversion.h"
#include "acus/imaging/ultrasound/speckle/noise_tile.h"

namespace acus::ultrasound {

/// Equations: docs/models/ultrasound_alamilla.md. Not for two threads at a time: it holds buffers.
class AlamillaRenderer {
 public:
  /// Keeps references to `labels` and `triangles`, which must outlive this.
  /// @param triangles  What the labels of samples come from in place of the label map, which then
  ///     gives the directions of fibres only; null: the label map.
  /// @throws InputError if the probe or an option is out of range, or the label map or a surface
  ///     has a tissue without a row.
  AlamillaRenderer(const volume::LabelMap& labels, const acoustics::Probe& probe,
                   const AlamillaOptions& options,
                   const tracing::SurfaceTracer* triangles = nullptr);

  /// Allocation-free after the first call. The same bits with any `num_threads`.
  /// @throws InputError if the pose or the needle is not finite.
  /// @param rest  Where the tissue was at rest; null: it has not moved. Textures move with it.
  void Render(const Eigen::Isometry3d& ct_from_probe,
              const std::optional<image::NeedleInImage>& needle, image::GrayImage& out,
              int num_threads = 1, const slicing::RestMap* rest = nullptr);

  const image::ImageGeometry& image() const { return conversion_.image(); }
  const acoustics::Probe& probe() const { return probe_; }

 private:
  /// Surfaces that one line remembers; the deepest of more are not drawn as lines.
  static constexpr int kMaxSurfaces = 48;
  static constexpr int kMaxTaps = 64;  ///< Of the blur, to each side.

  struct Surface {
    int sample;
    int label;  ///< Behind it.
    float grey;
  };
  struct TissueRow {
    float grey = 0.0F;
    float contrast = 0.0F;
    float passed = 1.0F;  ///< Share of grey left by one sample.
    float reflection = 0.0F;
    bool blocks = false;
    bool thin_fibres = false;
    std::array<float, 9> tile_from_index{};  ///< Row by row.
    int example = -1;                        ///< Of examples_; -1: noise.
  };

  /// Texture of one tissue. Its places are in mm, along the fibres first.
  struct ExampleRow {
    ExampleTexture texture;
    Eigen::Vector3d fibre;      ///< Unit length, CT.
    float share_across = 0.0F;  ///< Of the image of the last pose.
    float per_mean = 1.0F;      ///< One over twice the mean grey.
  };

  void FillTissues(const tracing::SurfaceTracer* triangles);
  Eigen::Matrix3d AddExample(const AlamillaTissue& tissue, volume::Label label, bool fibrous);
  void TurnExamples(const Eigen::Vector3d& image_normal_in_ct);
  void SampleRow(int k);
  volume::Label LabelAt(const float* index) const;
  void FillCoupling();
  void FindSurfaces(int first, int count);
  void WeighSurfaces(int line);
  float SlopeOf(int line, const Surface& surface) const;
  float BlurredNoise(int k, int line) const;
  void ShadeLines(int first, int count);

  const volume::LabelMap& labels_;
  std::optional<tracing::BeamLabels> traced_;  ///< Empty: labels come from the label map.
  acoustics::Probe probe_;
  AlamillaOptions options_;
  acoustics::ScanGrid grid_;
  ScanConversion conversion_;
  Eigen::Affine3d index_from_ct_;
  double brightness_;                                            ///< That the gain adds.
  Eigen::Matrix3d probe_from_ct_ = Eigen::Matrix3d::Identity();  ///< Rotation, of the last pose.
  std::optional<NoiseTile> noise_tile_;                          ///< Empty if there is no speckle.
  std::optional<FibreField> fibres_;                             ///< Empty if nothing is fibrous.
  std::array<TissueRow, 257> tissue_{};                          ///< By label; the last: needle.
  std::vector<ExampleRow> examples_;
  slicing::BeamLines lines_;
  slicing::BeamBend bend_;
  PixelShift shift_;
  slicing::BeamImage label_;  ///< Labels as floats, as PaintNeedle wants.
  slicing::BeamImage noise_;  ///< 0 to 1.
  slicing::BeamImage grey_;
  std::vector<Surface> surface_;  ///< kMaxSurfaces per line.
  std::vector<int> num_surfaces_;
  std::vector<int> begins_;  ///< By line: first sample in the body; samples() if there is none.
};

}  // namespace acus::ultrasound
