// The HDF5 file of a stack. The library may be built without locks: one lock here serves all files.
#include <array>
#include <hdf5.h>
#include <mutex>
#include <optional>
#include <span>

#include "acus/base/core/error.h"
#include "acus/run/replay/image_stack.h"

namespace acus::replay {
namespace {

namespace fs = std::filesystem;

std::mutex& Hdf5Mutex() {
  static std::mutex mutex;
  return mutex;
}

/// An HDF5 identifier with automatic closing.
class H5Id {
 public:
  H5Id(hid_t id, herr_t (*close)(hid_t), const fs::path& file) : id_(id), close_(close) {
    ACUS_REQUIRE(id >= 0, file.string(), ": cannot be written; is the disk full?");
  }
  ~H5Id() { close_(id_); }
  H5Id(const H5Id&) = delete;
  H5Id& operator=(const H5Id&) = delete;
  operator hid_t() const { return id_; }  // NOLINT: as the library's functions take it.

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

/// Without times, so that the same content gives the same bytes.
hid_t PlainCreation(hid_t kind) {
  const hid_t list = H5Pcreate(kind);
  if (list >= 0) H5Pset_obj_track_times(list, false);
  return list;
}

void WriteArray(hid_t file, const char* name, std::span<const hsize_t> size, hid_t file_type,
                hid_t memory_type, const void* values, const fs::path& path) {
  const H5Id space(H5Screate_simple(static_cast<int>(size.size()), size.data(), nullptr), H5Sclose,
                   path);
  const H5Id creation(PlainCreation(H5P_DATASET_CREATE), H5Pclose, path);
  const H5Id set(H5Dcreate2(file, name, file_type, space, H5P_DEFAULT, creation, H5P_DEFAULT),
                 H5Dclose, path);
  ACUS_REQUIRE(H5Dwrite(set, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0,
               path.string(), ": cannot be written; is the disk full?");
}

/// A growing dataset of images of one size: chunks of one image, compressed.
class GrowingImages {
 public:
  GrowingImages(hid_t file, const char* name, const image::ImageGeometry& image,
                const fs::path& path)
      : path_(path),
        size_{0, static_cast<hsize_t>(image.height_px), static_cast<hsize_t>(image.width_px)} {
    const std::array<hsize_t, 3> most = {H5S_UNLIMITED, size_[1], size_[2]};
    const std::array<hsize_t, 3> chunk = {1, size_[1], size_[2]};
    const H5Id space(H5Screate_simple(3, size_.data(), most.data()), H5Sclose, path);
    const H5Id creation(PlainCreation(H5P_DATASET_CREATE), H5Pclose, path);
    constexpr unsigned kCompression = 4;
    H5Pset_chunk(creation, 3, chunk.data());
    H5Pset_deflate(creation, kCompression);
    set_.emplace(H5Dcreate2(file, name, H5T_STD_U8LE, space, H5P_DEFAULT, creation, H5P_DEFAULT),
                 H5Dclose, path);
  }

  void Append(const image::GrayImage& image) {
    const std::array<hsize_t, 3> first = {size_[0], 0, 0};
    const std::array<hsize_t, 3> count = {1, size_[1], size_[2]};
    ++size_[0];
    ACUS_REQUIRE(H5Dset_extent(*set_, size_.data()) >= 0, path_.string(),
                 ": cannot be written; is the disk full?");
    const H5Id space(H5Dget_space(*set_), H5Sclose, path_);
    const H5Id one(H5Screate_simple(3, count.data(), nullptr), H5Sclose, path_);
    H5Sselect_hyperslab(space, H5S_SELECT_SET, first.data(), nullptr, count.data(), nullptr);
    ACUS_REQUIRE(
        H5Dwrite(*set_, H5T_NATIVE_UINT8, one, space, H5P_DEFAULT, image.pixels.data()) >= 0,
        path_.string(), ": cannot be written; is the disk full?");
  }

 private:
  fs::path path_;
  std::array<hsize_t, 3> size_;
  std::optional<H5Id> set_;
};

class Hdf5Stack : public ImageStack {
 public:
  Hdf5Stack(const fs::path& folder, const StackGeometry& geometry) : path_(folder / kName) {
    const std::lock_guard lock(Hdf5Mutex());
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // HDF5 would print its messages to stderr.
    const H5Id creation(PlainCreation(H5P_FILE_CREATE), H5Pclose, path_);
    file_.emplace(H5Fcreate(path_.c_str(), H5F_ACC_TRUNC, creation, H5P_DEFAULT), H5Fclose, path_);
    images_.emplace(*file_, "images", geometry.image, path_);
    labels_.emplace(*file_, "labels", geometry.image, path_);
    const std::array<hsize_t, 2> size = {static_cast<hsize_t>(geometry.image.height_px),
                                         static_cast<hsize_t>(geometry.image.width_px)};
    WriteArray(*file_, "depth_mm", size, H5T_IEEE_F32LE, H5T_NATIVE_FLOAT, geometry.depth_mm.data(),
               path_);
  }

  ~Hdf5Stack() override {
    const std::lock_guard lock(Hdf5Mutex());
    Close();
  }

  void Append(const image::GrayImage& image, const image::GrayImage& labels) override {
    const std::lock_guard lock(Hdf5Mutex());
    images_->Append(image);
    labels_->Append(labels);
  }

  void Finish(const FrameTable& table) override {
    const std::lock_guard lock(Hdf5Mutex());
    std::vector<double> values(table.num_rows());
    const std::array<hsize_t, 1> size = {table.num_rows()};
    {
      const H5Id group(H5Gcreate2(*file_, "frames", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                       H5Gclose, path_);
      for (std::size_t column = 0; column < FrameTable::Columns().size(); ++column) {
        for (std::size_t n = 0; n < values.size(); ++n) values[n] = table.row(n)[column];
        WriteArray(group, FrameTable::Columns()[column].c_str(), size, H5T_IEEE_F64LE,
                   H5T_NATIVE_DOUBLE, values.data(), path_);
      }
    }
    ACUS_REQUIRE(H5Fflush(*file_, H5F_SCOPE_GLOBAL) >= 0, path_.string(),
                 ": cannot be written; is the disk full?");
    Close();
  }

  std::map<std::string, std::string> Files() const override {
    return {{"image", "labelled.h5:images"},
            {"labels", "labelled.h5:labels"},
            {"depth_mm", "labelled.h5:depth_mm"}};
  }

 private:
  static constexpr const char* kName = "labelled.h5";

  void Close() {
    labels_.reset();
    images_.reset();
    file_.reset();
  }

  fs::path path_;
  std::optional<H5Id> file_;
  std::optional<GrowingImages> images_;
  std::optional<GrowingImages> labels_;
};

}  // namespace

std::unique_ptr<ImageStack> MakeHdf5Stack(const fs::path& folder, const StackGeometry& geometry) {
  return std::make_unique<Hdf5Stack>(folder, geometry);
}

}  // namespace acus::replay
