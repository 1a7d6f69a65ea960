// One organ of a patient, from where several atlas patients have it.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "acus/patient/atlas/organ_cut.h"
#include "acus/patient/atlas/patient_map.h"

namespace acus::atlas {

/// A patient, and what each atlas patient says of him.
struct CarriedAtlas {
  volume::Grid<float> hu;    ///< Coarse.
  volume::LabelMap tissues;  ///< On the same grid, without the organs that are to be found.
  std::vector<CarriedLabels> carried;
};

/// An organ as it was cut out, and what it was cut from. All on one cubic grid.
struct FoundOrgan {
  OrganSearch search;
  volume::Grid<float> u;       ///< In [0, 1]; above 0.5 is the organ.
  segmentation::Mask covered;  ///< What at least one atlas patient shows.
  volume::LabelMap tissues;
};

/// @param tissue  A label's name.
/// @param reach_mm  How far the organ may lie from where it is in the aligned body; see Placed.
/// @return None if no atlas patient has the organ where the CT shows the body.
std::optional<FoundOrgan> FindOrgan(const CarriedAtlas& patient, std::string_view tissue,
                                    double reach_mm, int num_threads);

}  // namespace acus::atlas
