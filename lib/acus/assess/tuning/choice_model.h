// What the choice of a setting believes about settings that were not measured.
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

/// One part of an outcome: cost in us (forces) or ms (images); error squared, in N^2 or as a share
/// of the squared grey range. Infinite if it is not usable, NaN if the scene has no such part.
CostAndError PartOf(const Outcome& outcome, int part);

/// The same back into an outcome's units; what is below zero becomes zero.
void SetPart(Outcome& outcome, int part, const CostAndError& value);

/// How costs of several knobs go together: those of different stages add up, those of lines and
/// samples multiply. Which share of a law is the product; the rest is the sum.
using ProductShare = double;
inline constexpr ProductShare kSum = 0.0;
inline constexpr ProductShare kProduct = 1.0;
inline constexpr std::array<ProductShare, 5> kLaws = {kSum, 0.25, 0.5, 0.75, kProduct};

/// Costs and squared errors of knobs that were turned alone, added up, and corrected around joint
/// settings that were measured.
class ChoiceModel {
 public:
  ChoiceModel(const std::vector<ChoiceKnob>& knobs, double noise);

  /// The given setting; first.
  void AddGiven(const Outcome& outcome);
  /// One knob turned away from the given setting.
  void AddAlone(std::size_t knob, int index, const Outcome& outcome);
  /// Any setting, as measured.
  void AddMeasured(const ValueIndices& indices, const Outcome& outcome);

  /// False if the index was not usable even alone.
  bool IsUsable(std::size_t knob, int index) const;

  /// What turning one knob alone changes. Zero for the given index and for what was not measured.
  CostAndError Change(std::size_t knob, int index, int part) const;
  const CostAndError& Given(int part) const { return given_[static_cast<std::size_t>(part)]; }
  /// The largest error of a part, as given and of knobs turned alone; 1 if all are zero.
  double LargestError(int part) const;

  /// By changes alone; costs added up or multiplied. The error, which always adds up, may be below
  /// zero: it is only good for comparing.
  CostAndError Predicted(const ValueIndices& indices, int part, ProductShare law) const;

  /// What was measured, if these indices of the knobs that act on the part were; else, by the law
  /// that is nearest to the joint settings measured, the prediction times what it was wrong by at
  /// the nearest of them. If `hopeful`, the least that this may turn out to cost.
  CostAndError Best(const ValueIndices& indices, int part, bool hopeful) const;

 private:
  /// A setting as one part of the simulation sees it.
  struct Seen {
    ValueIndices indices;
    CostAndError measured;
  };
  ProductShare BestLaw(int part) const;
  CostAndError Corrected(const ValueIndices& indices, int part, const Seen* nearest,
                         ProductShare law) const;
  /// By which factor joint settings are at most cheaper or more expensive than the best law says,
  /// in 19 of 20 cases if it is wrong as it was so far; >= 1.
  double Doubt(int part) const;
  double Tiny(int part) const;  ///< Costs are taken to be at least this.
  int NumTurned(const ValueIndices& indices, int part) const;
  int Distance(const ValueIndices& a, const ValueIndices& b, int part) const;

  std::vector<ChoiceKnob> knobs_;
  double noise_;
  std::array<CostAndError, kNumParts> given_;
  std::vector<std::vector<std::array<CostAndError, kNumParts>>> change_;  ///< By knob, index, part.
  std::vector<std::vector<bool>> usable_;
  std::array<std::vector<Seen>, kNumParts> seen_;
  std::array<int, kNumParts> num_joint_{};  ///< Of `seen_`, those with more than one knob turned.
  std::array<double, kNumParts> largest_error_{};
  /// By part and law: sum of squares of the logarithm of what predictions were wrong by.
  std::array<std::array<double, kLaws.size()>, kNumParts> wrong_{};
};

}  // namespace acus::tuning
