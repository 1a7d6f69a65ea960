#include "acus/data/transforms/itk_transform_file.h"

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <hdf5.h>
#include <initializer_list>
#include <vector>

#include "acus/base/core/error.h"

namespace acus::transforms {
namespace {

/// An HDF5 identifier that is closed in the end.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;

  operator hid_t() const { return id_; }  // NOLINT: as the library's functions take it.
  bool ok() const { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

/// Reads `count` numbers of the first dataset of these names. Spelled "Tranform" in older files.
template <std::size_t count>
std::array<double, count> ReadNumbers(hid_t file, std::initializer_list<const char*> names,
                                      const std::string& label) {
  for (const char* name : names) {
    const Handle dataset(H5Dopen2(file, name, H5P_DEFAULT), H5Dclose);
    if (!dataset.ok()) continue;
    const Handle space(H5Dget_space(dataset), H5Sclose);
    const Handle type(H5Dget_type(dataset), H5Tclose);
    const Handle layout(H5Dget_create_plist(dataset), H5Pclose);
    ACUS_REQUIRE(space.ok() && type.ok() && layout.ok() && H5Tget_class(type) == H5T_FLOAT &&
                     H5Pget_external_count(layout) == 0 &&
                     H5Sget_simple_extent_npoints(space) == static_cast<hssize_t>(count),
                 label, ": ", name, " is not ", count,
                 " numbers; only one affine 3D transform is read");
    std::array<double, count> numbers{};
    ACUS_REQUIRE(
        H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data()) >= 0,
        label, ": ", name, " cannot be read; the file is damaged");
    for (const double number : numbers) {
      ACUS_REQUIRE(std::isfinite(number), label, ": ", name, " has a value that is not finite");
    }
    return numbers;
  }
  throw InputError(Message(label, ": has no ", *names.begin(),
                           "; it is not an ITK transform file, or "
                           "it is damaged"));
}

}  // namespace

Eigen::Matrix4d ReadItkAffine(std::span<const std::uint8_t> bytes, const std::string& label) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // Its own messages would go to stderr.
  H5PLset_loading_state(0);                     // A file must not make us load code.
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  ACUS_REQUIRE(access.ok() && H5Pset_fapl_core(access, 1U << 16U, /*backing_store=*/0) >= 0,
               "HDF5 cannot be started");
  std::vector<std::uint8_t> image(bytes.begin(), bytes.end());
  ACUS_REQUIRE(H5Pset_file_image(access, image.data(), image.size()) >= 0, label, ": is empty");
  const Handle file(H5Fopen("transform", H5F_ACC_RDONLY, access), H5Fclose);
  ACUS_REQUIRE(file.ok(), label, ": is not an HDF5 file, or it is damaged");
  const auto p = ReadNumbers<12>(
      file, {"/TransformGroup/0/TransformParameters", "/TransformGroup/0/TranformParameters"},
      label);
  const auto c = ReadNumbers<3>(
      file,
      {"/TransformGroup/0/TransformFixedParameters", "/TransformGroup/0/TranformFixedParameters"},
      label);
  const Eigen::Vector3d centre(c[0], c[1], c[2]);
  Eigen::Matrix4d affine = Eigen::Matrix4d::Identity();
  affine.topLeftCorner<3, 3>() =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(p.data());
  affine.topRightCorner<3, 1>() =
      Eigen::Vector3d(p[9], p[10], p[11]) + centre - affine.topLeftCorner<3, 3>() * centre;
  return affine;
}

Eigen::Matrix4d RasToParentFromItk(const Eigen::Matrix4d& lps_from_parent,
                                   const std::string& label) {
  const double determinant = lps_from_parent.topLeftCorner<3, 3>().determinant();
  ACUS_REQUIRE(lps_from_parent.allFinite() && std::abs(determinant) > 1e-12, label,
               ": the transform has no inverse");
  const Eigen::Matrix4d flip = Eigen::Vector4d(-1, -1, 1, 1).asDiagonal();
  return flip * lps_from_parent.inverse() * flip;
}

}  // namespace acus::transforms
