// Events found one after the other in what a profile leaves: a matching pursuit. A part of
// FindInternalPunctures and FindReleases.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "acus/patient/fitting/profile_fit.h"

namespace acus::fitting {

/// What one kind of event looks like at a place: columns, to be scaled.
struct EventShape {
  std::vector<double> place;  ///< A depth, then lengths > 0.
  Eigen::MatrixXd columns;
};

struct EventChoice {
  double gain = -1.0;  ///< Squares that it takes away.
  std::vector<double> place;
  Eigen::VectorXd factor;
  Eigen::MatrixXd columns;
};

/// A kind of event.
struct EventKind {
  std::function<EventShape(const std::vector<double>& place)> shape_at;
  /// Places to look at, given what remains by row.
  std::function<std::vector<std::vector<double>>(const Eigen::VectorXd& left)> places;
  std::function<double(const EventChoice&)> size_n;
  Eigen::Index positive = 0;  ///< So many of the first columns have factors >= 0.
  double parameters = 0.0;    ///< Of one event, for Akaike's criterion.
};

/// Adds the event that leaves least (of the places, then refined around the best), and so on until
/// an event is smaller than `least_n` or there are `most`. Keeps the first ones, as many as
/// Akaike's criterion is least for. In order of depth, scaled as they fit best together; `profile`
/// is set to what goes with them.
std::vector<EventChoice> FindEvents(const StrainedRows& rows, const EventKind& kind, double least_n,
                                    int most, ResistanceProfile& profile);

}  // namespace acus::fitting
