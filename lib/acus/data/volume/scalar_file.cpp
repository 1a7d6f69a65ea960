#include "acus/data/volume/scalar_file.h"

// First, so that ITK's headers find this Eigen's include guards and do not mix in their own copy.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <itkImageIOBase.h>
#include <itkMetaDataObject.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>
#include <optional>

#include "acus/base/core/error.h"
#include "acus/base/core/input_file.h"
#include "acus/data/volume/header_check.h"
#include "acus/data/volume/nifti_header.h"
#include "acus/data/volume/packed_nifti.h"

namespace acus::volume {
namespace {

namespace fs = std::filesystem;
using Component = itk::IOComponentEnum;

constexpr int kCompressionLevel = 2;  // Higher levels take several times as long for 5 % less.

enum class Format { kNifti, kNrrd, kMetaImage, kUnknown };

Format FormatOf(const fs::path& path) {
  std::string name = path.filename().string();
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
  if (name.ends_with(".nii") || name.ends_with(".nii.gz") || name.ends_with(".nii.bz2")) {
    return Format::kNifti;
  }
  if (name.ends_with(".nrrd") || name.ends_with(".nhdr")) return Format::kNrrd;
  if (name.ends_with(".mha") || name.ends_with(".mhd")) return Format::kMetaImage;
  return Format::kUnknown;
}

/// The ImageIO is made here by its class: ITK's factories would depend on what else is linked.
itk::ImageIOBase::Pointer MakeImageIo(const fs::path& path) {
  itk::Object::GlobalWarningDisplayOff();
  switch (FormatOf(path)) {
    case Format::kNifti:
      return itk::NiftiImageIO::New().GetPointer();
    case Format::kNrrd:
      return itk::NrrdImageIO::New().GetPointer();
    case Format::kMetaImage:
      return itk::MetaImageIO::New().GetPointer();
    case Format::kUnknown:
      break;
  }
  static constexpr std::array kArchives = {".zip", ".tar", ".tgz", ".gz", ".7z", ".rar"};
  const bool is_archive =
      std::ranges::find(kArchives, path.extension().string()) != kArchives.end();
  throw InputError(
      Message(path.string(),
              ": is none of the volume formats that are known by their ending: "
              ".nii, .nii.gz, .nii.bz2, .nrrd, .nhdr, .mha, .mhd",
              is_archive ? "; unpack the archive, and give the file or folder in it" : ""));
}

/// The readers of long and unsigned long give what the platform makes of it: 64 bits here.
ScalarType TypeOf(Component component, const fs::path& path) {
  static_assert(sizeof(long) == 8 && sizeof(int) == 4);
  switch (component) {
    case Component::CHAR:
      return ScalarType::kInt8;
    case Component::UCHAR:
      return ScalarType::kUint8;
    case Component::SHORT:
      return ScalarType::kInt16;
    case Component::USHORT:
      return ScalarType::kUint16;
    case Component::INT:
      return ScalarType::kInt32;
    case Component::UINT:
      return ScalarType::kUint32;
    case Component::LONG:
    case Component::LONGLONG:
      return ScalarType::kInt64;
    case Component::ULONG:
    case Component::ULONGLONG:
      return ScalarType::kUint64;
    case Component::FLOAT:
      return ScalarType::kFloat32;
    case Component::DOUBLE:
      return ScalarType::kFloat64;
    default:
      break;
  }
  throw InputError(
      Message(path.string(), ": its voxel type is not known; save it as 16-bit integers"));
}

Component ComponentOf(ScalarType type) {
  switch (type) {
    case ScalarType::kInt8:
      return Component::CHAR;
    case ScalarType::kUint8:
      return Component::UCHAR;
    case ScalarType::kInt16:
      return Component::SHORT;
    case ScalarType::kUint16:
      return Component::USHORT;
    case ScalarType::kInt32:
      return Component::INT;
    case ScalarType::kUint32:
      return Component::UINT;
    case ScalarType::kInt64:
      return Component::LONG;
    case ScalarType::kUint64:
      return Component::ULONG;
    case ScalarType::kFloat32:
      return Component::FLOAT;
    case ScalarType::kFloat64:
      return Component::DOUBLE;
  }
  return Component::UNKNOWNCOMPONENTTYPE;
}

Geometry GeometryOf(itk::ImageIOBase& io, const fs::path& path, int num_components) {
  const unsigned num_dimensions = io.GetNumberOfDimensions();
  ACUS_REQUIRE(num_dimensions >= 3 && num_dimensions <= 4, path.string(), ": has ", num_dimensions,
               " dimensions; a single 3-D volume is needed");
  ACUS_REQUIRE(num_dimensions == 3 || io.GetDimensions(3) == 1, path.string(), ": holds ",
               io.GetDimensions(3), " volumes; export a single one");
  ACUS_REQUIRE(io.GetNumberOfComponents() == static_cast<unsigned>(num_components), path.string(),
               ": has ", io.GetNumberOfComponents(),
               " values per voxel; a CT or label map has one, a displacement field three");
  Geometry geometry;
  for (unsigned d = 0; d < 3; ++d) {
    ACUS_REQUIRE(io.GetDimensions(d) >= 1 && io.GetDimensions(d) <= 65535, path.string(),
                 ": a size of ", io.GetDimensions(d), " voxels is not possible");
    geometry.size[d] = static_cast<int>(io.GetDimensions(d));
    geometry.spacing_mm[d] = io.GetSpacing(d);
    geometry.origin_mm[d] = io.GetOrigin(d);
    const std::vector<double> axis = io.GetDirection(d);
    geometry.direction.col(d) = Eigen::Vector3d(axis.at(0), axis.at(1), axis.at(2));
  }
  return geometry;
}

void CheckHeader(const fs::path& path, int num_components, bool one_of_several) {
  switch (FormatOf(path)) {
    case Format::kNifti:
      return CheckNiftiHeader(path, num_components, one_of_several);
    case Format::kNrrd:
      return CheckNrrdHeader(path, num_components);
    case Format::kMetaImage:
      return CheckMetaImageHeader(path, num_components);
    case Format::kUnknown:
      break;
  }
}

/// ITK's own words without the place in its sources.
std::string Reason(const itk::ExceptionObject& error) {
  std::string text = error.GetDescription();
  if (const auto at = text.find("): "); at != text.npos) text.erase(0, at + 3);
  std::ranges::replace(text, '\n', ' ');
  return text.substr(0, 200);
}

/// @param source  The file itself, or a copy of it that ITK reads.
ScalarFile ReadChecked(const fs::path& path, const fs::path& source, int num_components) {
  const auto io = MakeImageIo(source);
  io->SetFileName(source.string());
  io->ReadImageInformation();
  ScalarFile file;
  file.num_components = num_components;
  file.geometry = GeometryOf(*io, path, num_components);
  file.type = TypeOf(io->GetComponentType(), path);
  // A NIfTI file with a slope or an intercept holds smaller integers than it is read as; how many
  // bytes it needs was checked with its header.
  const std::uint64_t num_voxels =
      file.geometry.num_voxels() * static_cast<std::uint64_t>(num_components);
  const std::uint64_t stored =
      num_voxels * (FormatOf(path) == Format::kNifti ? 1 : BytesOf(file.type));
  ACUS_REQUIRE(stored <= MostVoxelBytes(source), path.string(), ": its header promises ", stored,
               " bytes of voxels, more than the file can hold; it is cut off or broken");
  for (const std::string& key : io->GetMetaDataDictionary().GetKeys()) {
    std::string value;
    if (itk::ExposeMetaData(io->GetMetaDataDictionary(), key, value)) file.keys[key] = value;
  }
  itk::ImageIORegion region(io->GetNumberOfDimensions());
  for (unsigned d = 0; d < io->GetNumberOfDimensions(); ++d)
    region.SetSize(d, io->GetDimensions(d));
  io->SetIORegion(region);
  file.bytes.resize(num_voxels * BytesOf(file.type));
  io->Read(file.bytes.data());
  return file;
}

void ConvertUnits(const fs::path& path, ScalarFile& file) {
  const double mm_per_unit = NrrdMillimetresPerUnit(path);
  if (mm_per_unit == 1.0) return;
  file.geometry.spacing_mm *= mm_per_unit;
  file.geometry.origin_mm *= mm_per_unit;
  file.notes.push_back(Message("its space units are ", mm_per_unit, " mm; they are converted"));
}

void UseSpace(const fs::path& path, ScalarFile& file) {
  const std::string space = NrrdSpace(path);
  file.is_placed = !space.empty();
  if (space != "left-anterior-superior") return;
  // ITK 5.2 turns x to the other side, where y is to be turned.
  const Eigen::Vector3d other_side(-1.0, -1.0, 1.0);
  file.geometry.origin_mm = other_side.asDiagonal() * file.geometry.origin_mm;
  file.geometry.direction = other_side.asDiagonal() * file.geometry.direction;
}

ScalarFile ReadPlain(const fs::path& path, int num_components, std::optional<int> volume) {
  CheckHeader(path, num_components, volume.has_value());
  try {
    std::vector<std::string> notes;
    const NiftiPart part{.channels = num_components, .volume = volume.value_or(0)};
    const auto copy = FormatOf(path) == Format::kNifti ? ReadableNifti(path, part, notes) : nullptr;
    ScalarFile file = ReadChecked(path, copy ? copy->path() : path, num_components);
    file.notes = std::move(notes);
    if (FormatOf(path) == Format::kNrrd) {
      ConvertUnits(path, file);
      UseSpace(path, file);
    } else if (FormatOf(path) == Format::kNifti) {
      file.is_placed = NiftiIsPlaced(path);
    }
    RequireUsable(file.geometry, path);
    MakeRightHanded(file);
    return file;
  } catch (const itk::ExceptionObject& exception) {
    throw InputError(Message(path.string(), ": cannot be read: ", Reason(exception),
                             "; export or copy it again"));
  } catch (const std::length_error&) {
    throw InputError(Message(path.string(), ": its header is broken; export it again"));
  }
}

/// What `read` returns for the file, or for its unpacked copy; messages name the file.
template <typename Read>
auto OfUnpacked(const fs::path& path, const Read& read) {
  const auto copy = UnpackedNifti(path);
  if (!copy) return read(path);
  try {
    return read(copy->path());
  } catch (const InputError& error) {
    std::string text = error.what();
    const std::string name = copy->path().string();
    if (const auto at = text.find(name); at != text.npos)
      text.replace(at, name.size(), path.string());
    throw InputError(text);
  }
}

/// @param volume  Of several over time; nothing: there must be one.
ScalarFile ReadFile(const fs::path& path, int num_components, std::optional<int> volume = {}) {
  ACUS_REQUIRE(RequireInputFile(path) > 0, path.string(), ": is empty");
  MakeImageIo(path);  // Refuses unknown endings before anything is read.
  return OfUnpacked(
      path, [&](const fs::path& plain) { return ReadPlain(plain, num_components, volume); });
}

}  // namespace

std::size_t BytesOf(ScalarType type) {
  switch (type) {
    case ScalarType::kInt8:
    case ScalarType::kUint8:
      return 1;
    case ScalarType::kInt16:
    case ScalarType::kUint16:
      return 2;
    case ScalarType::kInt32:
    case ScalarType::kUint32:
    case ScalarType::kFloat32:
      return 4;
    case ScalarType::kInt64:
    case ScalarType::kUint64:
    case ScalarType::kFloat64:
      return 8;
  }
  return 0;
}

bool IsScalarFileName(const fs::path& path) {
  return FormatOf(path) != Format::kUnknown;
}

std::string VolumeStem(const fs::path& path) {
  std::string name = path.filename().string();
  for (const std::string_view ending :
       {".gz", ".bz2", ".nii", ".nrrd", ".nhdr", ".seg", ".mha", ".mhd", ".vti", ".dcm"}) {
    if (name.ends_with(ending)) name.erase(name.size() - ending.size());
  }
  return name;
}

void RequireUsable(const Geometry& geometry, const fs::path& path) {
  const auto& spacing = geometry.spacing_mm;
  ACUS_REQUIRE((geometry.size >= 1).all(), path.string(), ": the volume is empty");
  ACUS_REQUIRE((spacing > 1e-4).all() && (spacing < 1e4).all(), path.string(),
               ": the voxel spacing is ", spacing.transpose(), " mm; the header is broken");
  ACUS_REQUIRE(geometry.origin_mm.allFinite() && geometry.origin_mm.norm() < 1e6, path.string(),
               ": the origin is ", geometry.origin_mm.transpose(), " mm; the header is broken");
  const Eigen::Matrix3d gram = geometry.direction.transpose() * geometry.direction;
  ACUS_REQUIRE(
      gram.allFinite() && (gram - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-3,
      path.string(),
      ": its voxel axes are not perpendicular; resample it to a "
      "rectangular grid first (for example in 3D Slicer)");
}

void MakeRightHanded(ScalarFile& file) {
  Geometry& geometry = file.geometry;
  if (geometry.direction.determinant() > 0.0) return;
  const std::size_t slice = file.bytes.size() / static_cast<std::size_t>(geometry.size[2]);
  for (int k = 0, last = geometry.size[2] - 1; k < last; ++k, --last) {
    const auto low = file.bytes.begin() + static_cast<std::ptrdiff_t>(slice) * k;
    const auto high = file.bytes.begin() + static_cast<std::ptrdiff_t>(slice) * last;
    std::swap_ranges(low, low + static_cast<std::ptrdiff_t>(slice), high);
  }
  geometry.origin_mm +=
      geometry.direction.col(2) * (geometry.spacing_mm[2] * (geometry.size[2] - 1));
  geometry.direction.col(2) *= -1.0;
}

ScalarFile ReadScalarFile(const fs::path& path) {
  return ReadFile(path, 1);
}

int NumVolumes(const fs::path& path) {
  if (FormatOf(path) != Format::kNifti) return 1;
  return OfUnpacked(path,
                    [](const fs::path& plain) { return NiftiVolumes(ReadNiftiHeader(plain)); });
}

ScalarFile ReadVolumeOf(const fs::path& path, int number) {
  ACUS_REQUIRE(number >= 0 && number < NumVolumes(path), path.string(), ": there is no volume ",
               number + 1, "; it holds ", NumVolumes(path));
  return ReadFile(path, 1, number);
}

ScalarFile ReadVectorFile(const fs::path& path) {
  return ReadFile(path, 3);
}

ScalarFile ReadLayeredFile(const fs::path& path, int num_components) {
  return ReadFile(path, num_components);
}

void WriteScalarFile(const fs::path& path, const ScalarFile& file) {
  const std::string extension = path.extension().string();
  ACUS_REQUIRE(extension != ".mhd" && extension != ".nhdr", path.string(),
               ": header and data in two files are not written; use .mha or .nrrd");
  ACUS_REQUIRE(extension != ".bz2", path.string(), ": bzip2 is not written; use .nii.gz");
  RequireUsable(file.geometry, path);
  try {
    const auto io = MakeImageIo(path);
    io->SetFileName(path.string());
    io->SetNumberOfDimensions(3);
    itk::ImageIORegion region(3);
    for (unsigned d = 0; d < 3; ++d) {
      const Eigen::Vector3d axis = file.geometry.direction.col(d);
      const auto size = static_cast<itk::SizeValueType>(file.geometry.size[d]);
      io->SetDimensions(d, size);
      io->SetSpacing(d, file.geometry.spacing_mm[d]);
      io->SetOrigin(d, file.geometry.origin_mm[d]);
      io->SetDirection(d, std::vector<double>{axis[0], axis[1], axis[2]});
      region.SetSize(d, size);
    }
    io->SetPixelType(file.num_components == 1 ? itk::IOPixelEnum::SCALAR
                                              : itk::IOPixelEnum::VECTOR);
    io->SetNumberOfComponents(static_cast<unsigned>(file.num_components));
    io->SetComponentType(ComponentOf(file.type));
    io->SetUseCompression(true);
    io->SetCompressionLevel(kCompressionLevel);
    for (const auto& [key, value] : file.keys) {
      itk::EncapsulateMetaData<std::string>(io->GetMetaDataDictionary(), key, value);
    }
    io->SetIORegion(region);
    io->Write(file.bytes.data());
  } catch (const itk::ExceptionObject& exception) {
    throw InputError(Message(path.string(), ": cannot be written: ", Reason(exception)));
  }
}

}  // namespace acus::volume
