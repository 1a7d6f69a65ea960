#include "support/slicer_files.h"

#include <gtest/gtest.h>
#include <hdf5.h>
#include <zip.h>

#include "acus/base/core/atomic_file.h"

namespace acus::testing_support {
namespace {

void WriteNumbers(hid_t file, const char* name, const double* numbers, hsize_t count) {
  const hid_t links = H5Pcreate(H5P_LINK_CREATE);
  H5Pset_create_intermediate_group(links, 1);
  const hid_t space = H5Screate_simple(1, &count, nullptr);
  const hid_t set = H5Dcreate2(file, name, H5T_IEEE_F64LE, space, links, H5P_DEFAULT, H5P_DEFAULT);
  EXPECT_GE(H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers), 0);
  H5Dclose(set);
  H5Sclose(space);
  H5Pclose(links);
}

}  // namespace

std::string ItkTransformFile(const Eigen::Matrix4d& lps_from_parent, const Eigen::Vector3d& centre,
                             const std::filesystem::path& scratch) {
  double parameters[12];
  const Eigen::Matrix3d linear = lps_from_parent.topLeftCorner<3, 3>();
  const Eigen::Vector3d offset = lps_from_parent.topRightCorner<3, 1>();
  const Eigen::Vector3d translation = offset - centre + linear * centre;
  for (int i = 0; i < 9; ++i) parameters[i] = linear(i / 3, i % 3);
  for (int i = 0; i < 3; ++i) parameters[9 + i] = translation[i];
  const hid_t file = H5Fcreate(scratch.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  WriteNumbers(file, "/TransformGroup/0/TransformParameters", parameters, 12);
  WriteNumbers(file, "/TransformGroup/0/TransformFixedParameters", centre.data(), 3);
  H5Fclose(file);
  return ReadTextFile(scratch);
}

std::string ItkTransformsFile(const std::vector<ItkTransformPart>& parts,
                              const std::filesystem::path& scratch) {
  const hid_t file = H5Fcreate(scratch.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  const hid_t links = H5Pcreate(H5P_LINK_CREATE);
  H5Pset_create_intermediate_group(links, 1);
  const hid_t text = H5Tcopy(H5T_C_S1);
  H5Tset_size(text, H5T_VARIABLE);
  for (std::size_t n = 0; n < parts.size(); ++n) {
    const std::string group = "/TransformGroup/" + std::to_string(n) + "/";
    const hsize_t one = 1;
    const hid_t space = H5Screate_simple(1, &one, nullptr);
    const hid_t set = H5Dcreate2(file, (group + "TransformType").c_str(), text, space, links,
                                 H5P_DEFAULT, H5P_DEFAULT);
    const char* type = parts[n].type.c_str();
    EXPECT_GE(H5Dwrite(set, text, H5S_ALL, H5S_ALL, H5P_DEFAULT, &type), 0);
    H5Dclose(set);
    H5Sclose(space);
    if (parts[n].type.starts_with("Composite")) continue;
    WriteNumbers(file, (group + "TransformParameters").c_str(), parts[n].parameters.data(),
                 parts[n].parameters.size());
    WriteNumbers(file, (group + "TransformFixedParameters").c_str(), parts[n].fixed.data(),
                 parts[n].fixed.size());
  }
  H5Tclose(text);
  H5Pclose(links);
  H5Fclose(file);
  return ReadTextFile(scratch);
}

std::string ZipFile(const std::map<std::string, std::string>& files,
                    const std::filesystem::path& scratch) {
  int error = 0;
  zip_t* archive = zip_open(scratch.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &error);
  for (const auto& [name, content] : files) {
    zip_source_t* source = zip_source_buffer(archive, content.data(), content.size(), 0);
    EXPECT_GE(zip_file_add(archive, name.c_str(), source, ZIP_FL_OVERWRITE), 0);
  }
  EXPECT_EQ(zip_close(archive), 0);
  return ReadTextFile(scratch);
}

}  // namespace acus::testing_support
