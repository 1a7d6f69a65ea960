#include "acus/physics/breathing/motion_bound.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <fstream>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"

namespace acus::breathing {
namespace {

constexpr double kSmallestShare = 0.2;  // Of the bound at full inspiration.
static_assert(std::endian::native == std::endian::little, "bound.raw is little endian");

std::string BoundHeader(const volume::Geometry& nodes) {
  const auto vector = [](const Eigen::Vector3d& v) {
    return Message("(", NumberText(v[0]), ",", NumberText(v[1]), ",", NumberText(v[2]), ")");
  };
  std::string text = Message(
      "NRRD0005\ntype: float\ndimension: 3\nspace: left-posterior-superior\nsizes: ", nodes.size[0],
      " ", nodes.size[1], " ", nodes.size[2], "\nspace directions:");
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    text += " " + vector(nodes.direction.col(axis) * nodes.spacing_mm[axis]);
  }
  return text + "\nkinds: domain domain domain\nspace origin: " + vector(nodes.origin_mm) +
         "\nendian: little\nencoding: raw\ndata file: " + MotionBound::kFile + "\n";
}

}  // namespace

MotionBound::MotionBound(const volume::Geometry& nodes, std::vector<float> at_nodes_mm)
    : nodes_(nodes), index_from_ct_(nodes.index_from_ct()), at_nodes_mm_(std::move(at_nodes_mm)) {
  ACUS_REQUIRE(at_nodes_mm_.size() == nodes.num_voxels(),
               "bound of a motion: ", at_nodes_mm_.size(), " values for ", nodes.num_voxels(),
               " nodes");
  for (std::size_t n = 0; n < at_nodes_mm_.size(); ++n) {
    const float mm = at_nodes_mm_[n];
    ACUS_REQUIRE(std::isfinite(mm) && mm >= 0.0F, "bound of a motion: node ", n, " has ", mm,
                 " mm; it must be 0 or above");
  }
}

double MotionBound::Mm(const Eigen::Vector3d& rest_in_ct_mm, double normal_level) const noexcept {
  const Eigen::Array3d index = (index_from_ct_ * rest_in_ct_mm).array();
  if (!(index >= 0.0).all() || !(index <= (nodes_.size - 1).cast<double>()).all()) return 0.0;
  const Eigen::Array3i base = index.cast<int>().min(nodes_.size - 2).max(0);
  const Eigen::Array3d t = index - base.cast<double>();
  double sum = 0.0, total = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Array3i bit(corner & 1, (corner >> 1) & 1, corner >> 2);
    const Eigen::Array3i node = base + bit;
    if (!nodes_.Contains(node[0], node[1], node[2])) continue;
    const auto mm = static_cast<double>(at_nodes_mm_[nodes_.Index(node[0], node[1], node[2])]);
    if (mm == 0.0) continue;
    const double weight = (bit != 0).select(t, 1.0 - t).prod();
    sum += weight * mm;
    total += weight;
  }
  return total > 0.0 ? sum / total * std::max(std::abs(normal_level), kSmallestShare) : 0.0;
}

void WriteMotionBound(const std::filesystem::path& folder, const MotionBound& bound) {
  const std::filesystem::path path = folder / MotionBound::kFile;
  std::ofstream out(path, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bound.at_nodes_mm().data()),
            static_cast<std::streamsize>(bound.at_nodes_mm().size() * sizeof(float)));
  out.close();
  ACUS_REQUIRE(out.good(), path.string(), ": cannot be written; is the disk full?");
  WriteTextFile(folder / "bound.nhdr", BoundHeader(bound.nodes()));
}

MotionBound ReadMotionBound(const std::filesystem::path& file, const volume::Geometry& nodes) {
  std::error_code error;
  const auto found = std::filesystem::file_size(file, error);
  ACUS_REQUIRE(!error, file.string(), ": cannot be read; it belongs beside motion.json");
  const std::size_t bytes = sizeof(float) * nodes.num_voxels();
  ACUS_REQUIRE(found == bytes, file.string(), ": ", found, " bytes, where motion.json speaks of ",
               nodes.num_voxels(), " nodes: ", bytes,
               " bytes. Were the files copied whole, and from one folder?");
  std::vector<float> values(nodes.num_voxels());
  std::ifstream in(file, std::ios::binary);
  in.read(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(bytes));
  ACUS_REQUIRE(in.good(), file.string(), ": cannot be read to its end");
  try {
    return {nodes, std::move(values)};
  } catch (const InputError& broken) {
    throw InputError(file.string() + ": " + broken.what());
  }
}

}  // namespace acus::breathing
