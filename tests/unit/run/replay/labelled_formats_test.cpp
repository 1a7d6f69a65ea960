// The files of labelled images, read by other libraries: all formats hold the same pixels.
#include <gtest/gtest.h>
#include <hdf5.h>
#include <opencv2/imgcodecs.hpp>

#include "acus/base/core/csv.h"
#include "acus/data/volume/scalar_file.h"
#include "acus/run/replay/image_stack.h"
#include "support/temporary_folder.h"

namespace acus::replay {
namespace {

namespace fs = std::filesystem;

constexpr int kStackWidth = 37, kStackHeight = 21, kStackFrames = 5;

/// Something else in every pixel.
image::GrayImage StackImage(int frame, int step) {
  image::GrayImage image;
  image.Resize(kStackWidth, kStackHeight);
  for (std::size_t n = 0; n < image.pixels.size(); ++n) {
    image.pixels[n] = static_cast<std::uint8_t>(n * static_cast<std::size_t>(step) +
                                                11U * static_cast<std::size_t>(frame));
  }
  return image;
}

void WriteStack(LabelFormat format, const fs::path& folder) {
  fs::create_directories(folder);
  StackGeometry geometry{.image = {.width_px = kStackWidth,
                                   .height_px = kStackHeight,
                                   .lateral_mm_per_px = 0.4,
                                   .axial_mm_per_px = 0.3},
                         .depth_mm = {}};
  for (int n = 0; n < kStackWidth * kStackHeight; ++n) {
    geometry.depth_mm.push_back(0.25F * static_cast<float>(n));
  }
  const auto stack = MakeImageStack(format, folder, geometry);
  for (int frame = 0; frame < kStackFrames; ++frame) {
    stack->Append(StackImage(frame, 3), StackImage(frame, 5));
  }
  stack->Finish({});
}

using Pixels = std::vector<std::uint8_t>;

void ExpectFrames(const Pixels& pixels, int step) {
  ASSERT_EQ(pixels.size(), std::size_t{kStackWidth * kStackHeight * kStackFrames});
  for (int frame = 0; frame < kStackFrames; ++frame) {
    const Pixels expected = StackImage(frame, step).pixels;
    EXPECT_TRUE(std::equal(expected.begin(), expected.end(),
                           pixels.begin() + frame * kStackWidth * kStackHeight))
        << frame;
  }
}

TEST(LabelledFormats, PngIsReadByOpenCv) {
  const testing_support::TemporaryFolder temporary;
  WriteStack(LabelFormat::kPng, temporary.path());
  for (const auto& [folder, step] : {std::pair{"images", 3}, std::pair{"labels", 5}}) {
    Pixels pixels;
    for (int frame = 0; frame < kStackFrames; ++frame) {
      const fs::path file = temporary.path() / folder / Message("0000", frame, ".png");
      const cv::Mat image = cv::imread(file.string(), cv::IMREAD_UNCHANGED);
      ASSERT_EQ(image.type(), CV_8UC1);
      ASSERT_EQ(image.cols, kStackWidth);
      pixels.insert(pixels.end(), image.datastart, image.dataend);
    }
    ExpectFrames(pixels, step);
  }
}

TEST(LabelledFormats, NiftiHasThePixelsAndTheirSize) {
  const testing_support::TemporaryFolder temporary;
  WriteStack(LabelFormat::kNifti, temporary.path());
  for (const auto& [name, step] : {std::pair{"images.nii.gz", 3}, std::pair{"labels.nii.gz", 5}}) {
    const auto file = volume::ReadScalarFile(temporary.path() / name);
    EXPECT_EQ(file.geometry.size[0], kStackWidth);
    EXPECT_EQ(file.geometry.size[2], kStackFrames);
    EXPECT_NEAR(file.geometry.spacing_mm[0], 0.4, 1e-6);
    EXPECT_NEAR(file.geometry.spacing_mm[1], 0.3, 1e-6);
    const auto* first = reinterpret_cast<const std::uint8_t*>(file.bytes.data());
    ExpectFrames({first, first + file.bytes.size()}, step);
  }
  const auto depth = volume::ReadScalarFile(temporary.path() / "depth_mm.nii.gz");
  ASSERT_EQ(depth.type, volume::ScalarType::kFloat32);
  EXPECT_EQ(reinterpret_cast<const float*>(depth.bytes.data())[100], 25.0F);
}

/// All numbers of a dataset, and its size.
template <typename T>
std::vector<T> ReadHdf5(const fs::path& path, const char* name, hid_t type,
                        std::vector<hsize_t>& size) {
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t set = H5Dopen2(file, name, H5P_DEFAULT);
  const hid_t space = H5Dget_space(set);
  size.resize(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space)));
  std::vector<hsize_t> most(size.size());
  H5Sget_simple_extent_dims(space, size.data(), most.data());
  EXPECT_TRUE(std::equal(size.begin() + 1, size.end(), most.begin() + 1)) << "only longer stacks";
  std::vector<T> values(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
  EXPECT_GE(H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), 0) << name;
  H5Sclose(space);
  H5Dclose(set);
  H5Fclose(file);
  return values;
}

TEST(LabelledFormats, Hdf5HasThePixelsAndTheDepth) {
  const testing_support::TemporaryFolder temporary;
  WriteStack(LabelFormat::kHdf5, temporary.path());
  const fs::path file = temporary.path() / "labelled.h5";
  std::vector<hsize_t> size;
  for (const auto& [name, step] : {std::pair{"images", 3}, std::pair{"labels", 5}}) {
    ExpectFrames(ReadHdf5<std::uint8_t>(file, name, H5T_NATIVE_UINT8, size), step);
    EXPECT_EQ(size, (std::vector<hsize_t>{kStackFrames, kStackHeight, kStackWidth}));
  }
  const auto depth = ReadHdf5<float>(file, "depth_mm", H5T_NATIVE_FLOAT, size);
  EXPECT_EQ(size, (std::vector<hsize_t>{kStackHeight, kStackWidth}));
  EXPECT_EQ(depth[100], 25.0F);
}

}  // namespace
}  // namespace acus::replay
