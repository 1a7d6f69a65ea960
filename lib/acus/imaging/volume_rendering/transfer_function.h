// How tissue looks in a volume rendering: colour and opacity by Hounsfield units.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace acus::volume_rendering {

/// Between two nodes all values run linearly; beyond the first and the last as there.
struct OpacityNode {
  double hu = 0.0;
  double extinction_per_mm = 0.0;                  ///< Light that passes 1 mm is exp(-extinction).
  Eigen::Array3f colour = Eigen::Array3f::Ones();  ///< sRGB, 0 to 1.
};

/// "skin": what air touches, opaque; "bone"; "soft_tissue": organs through a haze of fat;
/// "vessels": blood with contrast agent, and bone with it.
/// @throws InputError naming the presets there are.
std::vector<OpacityNode> TransferPreset(std::string_view name);
std::span<const std::string_view> TransferPresetNames();

/// A preset in a view. Opacity 1 is as the preset says, 0 does not show it.
struct VolumeLayer {
  std::string preset;
  double opacity = 1.0;
};

/// The sum of layers, ready for rays: extinction and colour of a piece of ray along which the HU
/// run from one value to another. Integrated beforehand, so that a thin layer such as the skin is
/// not missed between two samples and shows no rings.
class TransferFunction {
 public:
  static constexpr float kLowestHu = -1024.0F;
  static constexpr int kCount = 4096;  ///< Values: to 3071 HU.

  /// Extinction times colour, and extinction, per mm.
  using Emission = Eigen::Array4f;

  TransferFunction() = default;
  /// @throws InputError for a preset that is not there, or an opacity outside [0, 1].
  explicit TransferFunction(std::span<const VolumeLayer> layers);
  /// @throws InputError if there are fewer than two nodes, they are not in rising order, an
  ///     extinction is negative or above 100, or a value is not finite.
  explicit TransferFunction(std::span<const OpacityNode> nodes);

  /// Mean over a piece of ray.
  Emission Between(float from_hu, float to_hu) const noexcept;
  /// True if something between the two can be seen.
  bool Shows(float low_hu, float high_hu) const noexcept;
  bool empty() const { return integral_.empty(); }

 private:
  void Add(std::span<const OpacityNode> nodes, double opacity);
  void Integrate();

  std::vector<Emission> integral_;  ///< Of the emission over HU, from kLowestHu; kCount values.
  std::vector<Emission> value_;
};

}  // namespace acus::volume_rendering
