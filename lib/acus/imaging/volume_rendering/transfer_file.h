// Transfer functions as files: configs/transfer_functions/*.json, format acus-transfer-function/1.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "acus/data/volume/volume.h"

namespace acus::volume_rendering {

/// Between two nodes all values run linearly; beyond the first and the last as there.
struct OpacityNode {
  double hu = 0.0;
  double extinction_per_mm = 0.0;                  ///< Light that passes 1 mm is exp(-extinction).
  Eigen::Array3f colour = Eigen::Array3f::Ones();  ///< sRGB, 0 to 1.
};

struct TransferFile {
  std::string name;
  std::vector<OpacityNode> nodes;
  std::vector<volume::Label> tissues;  ///< Where it holds; empty: everywhere.
};

/// "bone" is transfer_functions/bone.json of the configs; what has a folder or an extension is a
/// path, from `folder` or as config::FindConfig finds it.
/// @throws InputError naming the places that were tried.
std::filesystem::path FindTransferFunction(std::string_view name_or_path,
                                           const std::filesystem::path& folder);

/// @throws InputError for a file that is not of the format, a tissue that no label map has, nodes
///     that do not rise.
TransferFile ReadTransferFunction(const std::filesystem::path& path);

/// @throws InputError if there are fewer than two nodes, they are not in rising order, an
///     extinction is negative or above 100, or a value is not finite.
void CheckNodes(const std::vector<OpacityNode>& nodes, std::string_view where);

}  // namespace acus::volume_rendering
