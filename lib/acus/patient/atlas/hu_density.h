// How frequent each HU is in a region.
#pragma once

#include <vector>

namespace acus::atlas {

/// A blurred histogram of HU from -100 to 499; HU beyond count as the nearest of these.
class HuDensity {
 public:
  /// @param blur_hu  Standard deviation of the blur. @param floor  Count of every HU to begin with.
  HuDensity(int blur_hu, double floor) : blur_hu_(blur_hu), count_(kBins, floor) {}

  void Add(double hu) { count_[Bin(hu)] += 1.0; }

  /// Blurs and scales to a sum of 1. To be called once, after all Add().
  void Normalise();

  /// Per HU. @pre normalised.
  double At(double hu) const { return count_[Bin(hu)]; }
  int Peak() const;  ///< The most frequent HU. @pre normalised.

 private:
  static constexpr int kLowest = -100, kBins = 600;
  static std::size_t Bin(double hu);

  int blur_hu_;
  std::vector<double> count_;
};

}  // namespace acus::atlas
