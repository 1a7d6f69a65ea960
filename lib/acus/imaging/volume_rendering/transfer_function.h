// How tissue looks in a volume rendering: colour and opacity by Hounsfield units.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acus/imaging/volume_rendering/ray_kernel.h"
#include "acus/imaging/volume_rendering/tissue_classes.h"
#include "acus/imaging/volume_rendering/transfer_file.h"

namespace acus::volume_rendering {

/// A transfer function in a view. Opacity 1 is as its file says, 0 does not show it.
struct VolumeLayer {
  std::string preset;  ///< Name of a preset, or path of a file: see FindTransferFunction.
  double opacity = 1.0;
};

/// The sum of layers, ready for rays: extinction and colour of a piece of ray along which the HU
/// run from one value to another. Integrated beforehand, so that a thin layer such as the skin is
/// not missed between two samples and shows no rings. Layers that hold in some tissues only make
/// classes of labels, each with a sum of its own; class 0 is that of all other labels.
class TransferFunction {
 public:
  static constexpr float kLowestHu = -1024.0F;
  static constexpr int kCount = 4096;  ///< Values: to 3071 HU.

  /// Extinction times colour, and extinction, per mm.
  using Emission = Eigen::Array4f;

  TransferFunction() = default;
  /// @throws InputError for a preset that is not there or not valid, an opacity outside [0, 1], or
  ///     layers of more than TissueClasses::kMaxClasses - 1 tissues.
  explicit TransferFunction(std::span<const VolumeLayer> layers);
  /// @throws InputError as CheckNodes.
  explicit TransferFunction(const std::vector<OpacityNode>& nodes);

  /// Mean over a piece of ray.
  Emission Between(float from_hu, float to_hu, int tissue_class = 0) const noexcept;
  /// True if something between the two can be seen in one of the classes.
  bool Shows(float low_hu, float high_hu, TissueClasses::Set classes = 1) const noexcept;
  /// True if labels are needed.
  bool has_classes() const { return num_classes_ > 1; }
  const TissueClasses::ClassOfLabel& class_of_label() const { return class_of_label_; }
  int num_classes() const { return num_classes_; }
  bool empty() const { return integral_.empty(); }
  /// For the kernel; as long as this lives. @pre not empty.
  kernels::EmissionTable table() const noexcept {
    return {.integral = integral_.front().data(),
            .value = value_.front().data(),
            .lowest_hu = kLowestHu,
            .count = kCount};
  }

 private:
  void SetClasses(std::span<const TransferFile> files);
  void Add(std::span<const OpacityNode> nodes, double opacity, int tissue_class);
  void Integrate();

  int num_classes_ = 1;
  TissueClasses::ClassOfLabel class_of_label_{};
  std::vector<Emission> integral_;  ///< Of the emission over HU, from kLowestHu; kCount a class.
  std::vector<Emission> value_;
};

}  // namespace acus::volume_rendering
