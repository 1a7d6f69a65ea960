// Rigid registration of paired markers, and what it can be trusted for.
//
// FLE: fiducial localisation error, of one marker. FRE: fiducial registration error, what remains
// at the markers. TRE: target registration error, at a point that was not used. All are RMS lengths
// of 3D vectors, mm. FRE says little of TRE: the place of the target and the spread of the markers
// do.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "acus/data/transforms/landmarks.h"

namespace acus::registration {

struct MarkerFit {
  Eigen::Isometry3d ct_from_reference = Eigen::Isometry3d::Identity();
  transforms::Markers residual_mm;  ///< ct - ct_from_reference * reference, one column per marker.
  double fre_rms_mm = 0.0;
};

/// RMS distances of the markers from their mean along their principal axes, longest first, mm.
Eigen::Vector3d SpreadMm(const transforms::Markers& markers_mm);

/// The rigid transform that maps reference markers best onto CT markers: least squares, known
/// correspondence, no scale, never a mirror image (Umeyama 1991, doi:10.1109/34.88573).
///
/// @throws InputError if there are fewer than 3, or they lie on a line or in a point in either
///     space (second spread below 0.1 mm or a thousandth of the first).
MarkerFit FitMarkers(const transforms::Markers& reference_mm, const transforms::Markers& ct_mm);

/// The localisation error that explains a registration's FRE: <FLE^2> = <FRE^2> n / (n - 2)
/// (Sibson 1979; Fitzpatrick, West & Maurer 1998, doi:10.1109/42.736021, eq. 10). It is the sum of
/// the errors in both spaces. @pre n >= 3.
double FleFromFreMm(double fre_rms_mm, int num_markers);

struct TreEstimate {
  double rms_mm = 0.0;
  Eigen::Matrix3d covariance_mm2 = Eigen::Matrix3d::Zero();  ///< Its trace is rms_mm^2.
};

/// The expected TRE at a target, to first order in FLE, for isotropic FLE that is the same at all
/// markers: <TRE^2> = <FLE^2>/n (1 + 1/3 sum_k d_k^2 / f_k^2), with d_k the distance of the target
/// and f_k the RMS distance of the markers from principal axis k (Fitzpatrick, West & Maurer 1998,
/// eq. 46). Markers and target in one frame, mm. @pre the markers are not on a line.
TreEstimate ExpectedTre(const transforms::Markers& markers_mm, double fle_rms_mm,
                        const Eigen::Vector3d& target_mm);

/// One marker under suspicion: what the others say of it.
struct LeaveOneOut {
  double predicted_error_mm = 0.0;  ///< Its distance from where the others put it.
  double fre_without_mm = 0.0;
  double p_value = 1.0;  ///< Chance of such an improvement if all markers were equally good.
};

/// Omits each marker in turn. Markers without which the rest lie on a line have no answer.
///
/// The improvement of the sum of squares is held against what remains by an F test with 3 and
/// 3 n - 9 degrees of freedom (markers have 3 coordinates, the transform takes 6), corrected for n
/// tests (Bonferroni). @pre n >= 4.
std::vector<std::optional<LeaveOneOut>> LeaveEachOut(const transforms::Markers& reference_mm,
                                                     const transforms::Markers& ct_mm);

struct Outlier {
  Eigen::Index marker = 0;
  LeaveOneOut evidence;  ///< Among the markers that were left when it was found.
};

/// Markers that do not fit the others: the worst of LeaveEachOut, as long as its p_value is below
/// `significance`, is taken out, and the rest is tested again. Nothing if n < 4.
std::vector<Outlier> FindOutliers(const transforms::Markers& reference_mm,
                                  const transforms::Markers& ct_mm, double significance = 0.01);

/// Mistakes that a transform cannot repair, in words: two markers exchanged, a mirrored axis, a
/// wrong unit. Empty if there is no sign of any.
std::vector<std::string> CommonMistakes(const transforms::MarkerPairs& pairs);

/// Refuses two sets of points that no rigid transform can bring together.
/// @throws NoAnswerError if one set is the mirror image of the other; InputError if distances
/// differ
///     as units do, by a factor of five or more.
void RequireSameShape(const transforms::MarkerPairs& pairs);

}  // namespace acus::registration
