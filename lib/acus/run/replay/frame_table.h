// Data of labelled images, one row each: for CSV and HDF5.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acus/scene/simulation/image_labels.h"
#include "acus/scene/simulation/simulation.h"

namespace acus::replay {

/// NaN stands for a missing value: no needle, no such effect.
class FrameTable {
 public:
  /// Adds the row of an image. @param step  At or before its time; null: there was none.
  void AddFrame(const simulation::Scene& scene, const simulation::Snapshot& snapshot,
                const simulation::StepOutput* step, const simulation::ImageTruth& truth);

  /// docs/reference/formats_labelled.md explains each; poses are 3 x 4 matrices, row by row.
  static const std::vector<std::string>& Columns();
  std::size_t num_rows() const { return rows_.size(); }
  const std::vector<double>& row(std::size_t n) const { return rows_[n]; }

  /// Header and rows; the cell of a NaN is empty.
  std::string CsvText() const;

 private:
  std::vector<std::vector<double>> rows_;
};

}  // namespace acus::replay
