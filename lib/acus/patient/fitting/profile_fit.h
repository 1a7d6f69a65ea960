// Resistance profiles by linear least squares.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "acus/patient/fitting/mechanical_model.h"

namespace acus::fitting {

/// Samples of one phase in order of time; all columns as long.
struct StrainedRows {
  std::vector<double> depth_mm;
  std::vector<double> force_n;  ///< Without offset.
  std::vector<double> strain;   ///< S of the mechanical model, of one sign.
};

/// A column per knot: its hat function times the strain, so that columns * forces is the model.
Eigen::MatrixXd ProfileColumns(const StrainedRows& rows, const std::vector<double>& knots_mm);

/// The forces that solve normal * forces = right, with a trifle for bends (empty intervals stay
/// straight). @pre normal is square and as long as right.
std::vector<double> SolveProfile(Eigen::MatrixXd normal, const Eigen::VectorXd& right);

/// Least squares for the profile's forces alone, events held. Knots without samples near them
/// follow their neighbours.
void FitProfile(const StrainedRows& rows, std::span<const double> event_force_n,
                ResistanceProfile& profile);

}  // namespace acus::fitting
