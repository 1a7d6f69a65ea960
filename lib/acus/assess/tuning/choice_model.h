// The model that predicts costs and errors of settings that were not measured.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "acus/assess/tuning/choice.h"
#include "acus/assess/tuning/pareto.h"

namespace acus::tuning {

/// The parts of a simulation that a goal can name.
inline constexpr int kNumParts = 2;  ///< 0: forces, 1: images.

bool Touches(const ChoiceKnob& knob, int part);

/// One part of an outcome: cost in us (forces) or ms (images); squared error, in N^2 or as a share
/// of the squared grey range. Infinite if it is not usable, NaN if the scene has no such part.
CostAndError PartOf(const Outcome& outcome, int part);

/// The inverse of PartOf; negative values become zero.
void SetPart(Outcome& outcome, int part, const CostAndError& value);

/// The law for costs of several parameters: those of different stages add up, those of lines and
/// samples multiply. The share of the product; the remainder is the sum.
using ProductShare = double;
inline constexpr ProductShare kSum = 0.0;
inline constexpr ProductShare kProduct = 1.0;
inline constexpr std::array<ProductShare, 5> kLaws = {kSum, 0.25, 0.5, 0.75, kProduct};

/// Costs and squared errors of parameters that were varied alone, added up, and corrected around
/// measured joint settings.
class ChoiceModel {
 public:
  ChoiceModel(const std::vector<ChoiceKnob>& knobs, double noise);

  /// The given setting; to be called first.
  void AddGiven(const Outcome& outcome);
  /// One parameter changed from the given setting.
  void AddAlone(std::size_t knob, int index, const Outcome& outcome);
  /// Any setting, as measured.
  void AddMeasured(const ValueIndices& indices, const Outcome& outcome);

  /// False if the index was not usable even alone.
  bool IsUsable(std::size_t knob, int index) const;

  /// The change by varying one parameter alone. Zero for the given index and for unmeasured ones.
  CostAndError Change(std::size_t knob, int index, int part) const;
  const CostAndError& Given(int part) const { return given_[static_cast<std::size_t>(part)]; }
  /// The largest error of a part, in the given setting and with parameters changed alone; 1 if all
  /// are zero.
  double LargestError(int part) const;

  /// Prediction from the changes alone; costs added or multiplied. The error, which is always
  /// added, may be negative: it serves comparisons only.
  CostAndError Predicted(const ValueIndices& indices, int part, ProductShare law) const;

  /// The measurement, if these indices of the parameters that affect the part were measured; else
  /// the prediction by the law that fits the measured joint settings best, times its error factor
  /// at the nearest of them. If `hopeful`, the lower bound of the expected cost.
  CostAndError Best(const ValueIndices& indices, int part, bool hopeful) const;

 private:
  /// The indices and results of a setting for one part of the simulation.
  struct Seen {
    ValueIndices indices;
    CostAndError measured;
  };
  ProductShare BestLaw(int part) const;
  CostAndError Corrected(const ValueIndices& indices, int part, const Seen* nearest,
                         ProductShare law) const;
  /// The factor by which costs of joint settings differ from the best law at most, in 19 of 20
  /// cases, estimated from the errors so far; >= 1.
  double Doubt(int part) const;
  double Tiny(int part) const;  ///< Lower bound of costs.
  int NumTurned(const ValueIndices& indices, int part) const;
  int Distance(const ValueIndices& a, const ValueIndices& b, int part) const;

  std::vector<ChoiceKnob> knobs_;
  double noise_;
  std::array<CostAndError, kNumParts> given_;
  std::vector<std::vector<std::array<CostAndError, kNumParts>>> change_;  ///< By knob, index, part.
  std::vector<std::vector<bool>> usable_;
  std::array<std::vector<Seen>, kNumParts> seen_;
  std::array<int, kNumParts> num_joint_{};  ///< Settings in `seen_` that change several.
  std::array<double, kNumParts> largest_error_{};
  /// By part and law: sum of squares of the logarithm of the predictions' error factors.
  std::array<std::array<double, kLaws.size()>, kNumParts> wrong_{};
};

}  // namespace acus::tuning
