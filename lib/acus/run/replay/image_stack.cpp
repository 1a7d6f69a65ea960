#include "acus/run/replay/image_stack.h"

#include <cstdio>
#include <cstring>

#include "acus/base/core/error.h"
#include "acus/data/image/png.h"
#include "acus/data/volume/scalar_file.h"

namespace acus::replay {
namespace {

namespace fs = std::filesystem;

/// Columns along the first axis, rows along the second, images along the third.
volume::ScalarFile StackFile(const image::ImageGeometry& image, std::size_t count,
                             volume::ScalarType type) {
  volume::ScalarFile file;
  file.geometry.size = {image.width_px, image.height_px, static_cast<int>(count)};
  file.geometry.spacing_mm = {image.lateral_mm_per_px, image.axial_mm_per_px, 1.0};
  file.type = type;
  return file;
}

void WriteDepth(const fs::path& path, const StackGeometry& geometry) {
  volume::ScalarFile file = StackFile(geometry.image, 1, volume::ScalarType::kFloat32);
  file.bytes.resize(geometry.depth_mm.size() * sizeof(float));
  std::memcpy(file.bytes.data(), geometry.depth_mm.data(), file.bytes.size());
  volume::WriteScalarFile(path, file);
}

class PngStack : public ImageStack {
 public:
  PngStack(fs::path folder, const StackGeometry& geometry) : folder_(std::move(folder)) {
    fs::create_directories(folder_ / "images");
    fs::create_directories(folder_ / "labels");
    WriteDepth(folder_ / "depth_mm.nii.gz", geometry);
  }

  void Append(const image::GrayImage& image, const image::GrayImage& labels) override {
    char name[32];
    std::snprintf(name, sizeof name, "%05d.png", count_++);
    image::WritePng(folder_ / "images" / name, image);
    image::WritePng(folder_ / "labels" / name, labels);
  }

  void Finish(const FrameTable& /*table*/) override {}

  std::map<std::string, std::string> Files() const override {
    return {{"image", "images/%05d.png"},
            {"labels", "labels/%05d.png"},
            {"depth_mm", "depth_mm.nii.gz"}};
  }

 private:
  fs::path folder_;
  int count_ = 0;
};

class NiftiStack : public ImageStack {
 public:
  NiftiStack(fs::path folder, const StackGeometry& geometry)
      : folder_(std::move(folder)), image_(geometry.image) {
    WriteDepth(folder_ / "depth_mm.nii.gz", geometry);
  }

  void Append(const image::GrayImage& image, const image::GrayImage& labels) override {
    Keep(image, images_);
    Keep(labels, labels_);
    ++count_;
  }

  void Finish(const FrameTable& /*table*/) override {
    if (count_ == 0) return;
    Write("images.nii.gz", images_);
    Write("labels.nii.gz", labels_);
  }

  std::map<std::string, std::string> Files() const override {
    return {
        {"image", "images.nii.gz"}, {"labels", "labels.nii.gz"}, {"depth_mm", "depth_mm.nii.gz"}};
  }

 private:
  static void Keep(const image::GrayImage& image, std::vector<std::byte>& bytes) {
    const auto* first = reinterpret_cast<const std::byte*>(image.pixels.data());
    bytes.insert(bytes.end(), first, first + image.pixels.size());
  }

  void Write(const char* name, std::vector<std::byte>& bytes) {
    volume::ScalarFile file = StackFile(image_, count_, volume::ScalarType::kUint8);
    file.bytes = std::move(bytes);
    volume::WriteScalarFile(folder_ / name, file);
  }

  fs::path folder_;
  image::ImageGeometry image_;
  std::size_t count_ = 0;
  std::vector<std::byte> images_;
  std::vector<std::byte> labels_;
};

}  // namespace

std::map<std::string, LabelFormat> LabelFormats() {
  return {{"none", LabelFormat::kNone},
          {"png", LabelFormat::kPng},
          {"nifti", LabelFormat::kNifti},
          {"hdf5", LabelFormat::kHdf5}};
}

std::unique_ptr<ImageStack> MakeImageStack(LabelFormat format, const fs::path& folder,
                                           const StackGeometry& geometry) {
  if (format == LabelFormat::kHdf5) return MakeHdf5Stack(folder, geometry);
  if (format == LabelFormat::kNifti) return std::make_unique<NiftiStack>(folder, geometry);
  return std::make_unique<PngStack>(folder, geometry);
}

}  // namespace acus::replay
