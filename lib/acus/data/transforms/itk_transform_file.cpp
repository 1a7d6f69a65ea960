#include "acus/data/transforms/itk_transform_file.h"

#include <Eigen/LU>
#include <cmath>
#include <cstring>
#include <functional>
#include <hdf5.h>
#include <nlohmann/json.hpp>
#include <utility>

#include "acus/base/config/json_from_child.h"
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

constexpr std::size_t kMostTransforms = 100;
constexpr hssize_t kMostNumbers = 64;

/// An HDF5 file in memory.
class TransformFile {
 public:
  TransformFile(std::span<const std::uint8_t> bytes, const std::string& label)
      : label_(label), image_(bytes.begin(), bytes.end()), file_(Open(image_, label), H5Fclose) {
    ACUS_REQUIRE(file_.ok(), label, ": is not an HDF5 file, or it is damaged");
  }

  bool HasTransform(std::size_t number) const {
    const std::string group = Message("/TransformGroup/", number);
    return H5Lexists(file_, "/TransformGroup", H5P_DEFAULT) > 0 &&
           H5Lexists(file_, group.c_str(), H5P_DEFAULT) > 0;
  }

  /// The numbers of a dataset of a transform. Spelled "Tranform" in older files.
  std::vector<double> Numbers(std::size_t transform, const std::string& what) const {
    for (const char* spelling : {"Transform", "Tranform"}) {
      const std::string name = Message("/TransformGroup/", transform, "/", spelling, what);
      const Handle dataset(H5Dopen2(file_, name.c_str(), H5P_DEFAULT), H5Dclose);
      if (dataset.ok()) return Read(dataset, name);
    }
    throw InputError(Message(label_, ": has no /TransformGroup/", transform, "/Transform", what,
                             "; it is not an ITK transform file, or it is damaged"));
  }

  /// The kind of a transform.
  std::string Type(std::size_t transform) const {
    const std::string name = Message("/TransformGroup/", transform, "/TransformType");
    const Handle dataset(H5Dopen2(file_, name.c_str(), H5P_DEFAULT), H5Dclose);
    ACUS_REQUIRE(dataset.ok(), label_, ": has no ", name, "; it is not an ITK transform file");
    const Handle space(H5Dget_space(dataset), H5Sclose);
    const Handle type(H5Dget_type(dataset), H5Tclose);
    ACUS_REQUIRE(space.ok() && type.ok() && H5Tget_class(type) == H5T_STRING &&
                     H5Sget_simple_extent_npoints(space) == 1,
                 label_, ": ", name, " is not a text; the file is damaged");
    std::string text;
    if (H5Tis_variable_str(type) > 0) {
      char* read = nullptr;
      if (H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, static_cast<void*>(&read)) >= 0 &&
          read != nullptr) {
        text.assign(read, strnlen(read, kLongestType));
      }
      H5Dvlen_reclaim(type, space, H5P_DEFAULT, static_cast<void*>(&read));
    } else if (const std::size_t size = H5Tget_size(type); size <= kLongestType) {
      text.resize(size);
      if (H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text.data()) < 0) text.clear();
      text.resize(strnlen(text.data(), text.size()));
    }
    ACUS_REQUIRE(!text.empty(), label_, ": ", name, " cannot be read; the file is damaged");
    return text;
  }

 private:
  static constexpr std::size_t kLongestType = 200;

  static hid_t Open(std::vector<std::uint8_t>& image, const std::string& label) {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // Its own messages would go to stderr.
    H5PLset_loading_state(0);                     // A file must not make us load code.
    const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    ACUS_REQUIRE(access.ok() && H5Pset_fapl_core(access, 1U << 16U, /*backing_store=*/0) >= 0,
                 "HDF5 cannot be started");
    ACUS_REQUIRE(H5Pset_file_image(access, image.data(), image.size()) >= 0, label, ": is empty");
    return H5Fopen("transform", H5F_ACC_RDONLY, access);
  }

  std::vector<double> Read(hid_t dataset, const std::string& name) const {
    const Handle space(H5Dget_space(dataset), H5Sclose);
    const Handle type(H5Dget_type(dataset), H5Tclose);
    const Handle layout(H5Dget_create_plist(dataset), H5Pclose);
    const hssize_t count = space.ok() ? H5Sget_simple_extent_npoints(space) : -1;
    ACUS_REQUIRE(type.ok() && layout.ok() && H5Tget_class(type) == H5T_FLOAT &&
                     H5Pget_external_count(layout) == 0 && count >= 0 && count <= kMostNumbers,
                 label_, ": ", name, " is not a list of up to ", kMostNumbers,
                 " numbers; rigid and affine transforms are read, no B-splines or fields");
    std::vector<double> numbers(static_cast<std::size_t>(count));
    ACUS_REQUIRE(count == 0 || H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT,
                                       numbers.data()) >= 0,
                 label_, ": ", name, " cannot be read; the file is damaged");
    for (const double number : numbers) {
      ACUS_REQUIRE(std::isfinite(number), label_, ": ", name, " has a value that is not finite");
    }
    return numbers;
  }

  const std::string& label_;
  std::vector<std::uint8_t> image_;
  Handle file_;
};

std::vector<ItkTransform> ReadHere(std::span<const std::uint8_t> bytes, const std::string& label) {
  const TransformFile file(bytes, label);
  std::vector<ItkTransform> transforms;
  while (file.HasTransform(transforms.size())) {
    const std::size_t number = transforms.size();
    ACUS_REQUIRE(number < kMostTransforms, label, ": more than ", kMostTransforms, " transforms");
    ItkTransform transform{.type = file.Type(number), .parameters = {}, .fixed = {}};
    if (!transform.type.starts_with("Composite")) {
      transform.parameters = file.Numbers(number, "Parameters");
      transform.fixed = file.Numbers(number, "FixedParameters");
    }
    transforms.push_back(std::move(transform));
  }
  ACUS_REQUIRE(!transforms.empty(), label,
               ": has no /TransformGroup/0; it is not an ITK transform file, or it is damaged");
  return transforms;
}

Eigen::Matrix4d FirstAffine(std::span<const std::uint8_t> bytes, const std::string& label) {
  const TransformFile file(bytes, label);
  const auto p = file.Numbers(0, "Parameters");
  const auto c = file.Numbers(0, "FixedParameters");
  ACUS_REQUIRE(p.size() == 12 && c.size() == 3, label, ": has ", p.size(), " and ", c.size(),
               " numbers; only one affine 3D transform is read, of 12 numbers and 3");
  const Eigen::Vector3d centre(c[0], c[1], c[2]);
  Eigen::Matrix4d affine = Eigen::Matrix4d::Identity();
  affine.topLeftCorner<3, 3>() =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(p.data());
  affine.topRightCorner<3, 1>() =
      Eigen::Vector3d(p[9], p[10], p[11]) + centre - affine.topLeftCorner<3, 3>() * centre;
  return affine;
}

/// What `work` returns as JSON. In a separate process, as libhdf5 crashes on some damaged files,
/// and allocates what others declare.
nlohmann::json FromChild(const std::string& label, const std::function<nlohmann::json()>& work) {
  core::ChildLimits limits;
  limits.memory_bytes = 1e9;
  return config::JsonFromChild(limits, label + ": cannot be read; the file is damaged", work);
}

}  // namespace

std::vector<ItkTransform> ReadItkTransforms(std::span<const std::uint8_t> bytes,
                                            const std::string& label) {
  const nlohmann::json read = FromChild(label, [&] {
    auto transforms = nlohmann::json::array();
    for (const ItkTransform& t : ReadHere(bytes, label)) {
      transforms.push_back({t.type, t.parameters, t.fixed});
    }
    return transforms;
  });
  std::vector<ItkTransform> transforms;
  for (const auto& t : read)
    transforms.push_back({.type = t[0], .parameters = t[1], .fixed = t[2]});
  return transforms;
}

std::vector<Eigen::Matrix4d> ReadItkAffines(const std::vector<ItkTransformSource>& files) {
  if (files.empty()) return {};
  const nlohmann::json read = FromChild(files.front().label, [&] {
    auto matrices = nlohmann::json::array();
    for (const ItkTransformSource& file : files) {
      const Eigen::Matrix4d affine = FirstAffine(file.read(), file.label);
      matrices.push_back(std::vector<double>(affine.data(), affine.data() + affine.size()));
    }
    return matrices;
  });
  std::vector<Eigen::Matrix4d> affines;
  for (const std::vector<double> numbers : read) {
    affines.emplace_back(Eigen::Map<const Eigen::Matrix4d>(numbers.data()));
  }
  return affines;
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
