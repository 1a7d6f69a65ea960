#include "acus/data/volume/vti_file.h"

#include <cmath>
#include <cstring>
#include <fstream>
#include <regex>
#include <sstream>
#include <vtkDataArray.h>
#include <vtkErrorCode.h>
#include <vtkImageData.h>
#include <vtkMatrix3x3.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkXMLImageDataReader.h>

#include "acus/base/core/error.h"
#include "acus/base/core/input_file.h"
#include "acus/data/volume/header_check.h"

namespace acus::volume {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kHeadBytes = 65536;

/// The attribute `name` of the first element that has it in the head of the file.
std::string Attribute(const std::string& head, const std::string& name) {
  std::smatch match;
  const std::regex pattern("[ \\t\\n]" + name + "=\"([^\"]{0,200})\"");
  return std::regex_search(head, match, pattern) ? match[1].str() : "";
}

ScalarType TypeOf(int vtk_type, const fs::path& path) {
  switch (vtk_type) {
    case VTK_CHAR:
    case VTK_SIGNED_CHAR:
      return ScalarType::kInt8;
    case VTK_UNSIGNED_CHAR:
      return ScalarType::kUint8;
    case VTK_SHORT:
      return ScalarType::kInt16;
    case VTK_UNSIGNED_SHORT:
      return ScalarType::kUint16;
    case VTK_INT:
      return ScalarType::kInt32;
    case VTK_UNSIGNED_INT:
      return ScalarType::kUint32;
    case VTK_LONG:
    case VTK_LONG_LONG:
      return ScalarType::kInt64;
    case VTK_UNSIGNED_LONG:
    case VTK_UNSIGNED_LONG_LONG:
      return ScalarType::kUint64;
    case VTK_FLOAT:
      return ScalarType::kFloat32;
    case VTK_DOUBLE:
      return ScalarType::kFloat64;
    default:
      break;
  }
  throw InputError(Message(path.string(), ": its scalar type is not known"));
}

/// VTK allocates what WholeExtent says, before it looks for the data.
void CheckVtiHeader(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string head(kHeadBytes, '\0');
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(file.gcount()));
  ACUS_REQUIRE(head.find("<VTKFile") != head.npos && head.find("ImageData") != head.npos,
               path.string(), ": is not a VTK ImageData XML file");
  const std::string whole = Attribute(head, "WholeExtent");
  ACUS_REQUIRE(!whole.empty() && whole == Attribute(head, "Extent"), path.string(),
               ": needs a WholeExtent and one piece with the same Extent; the header is broken, or "
               "the volume is cut into pieces");
  std::istringstream numbers(whole);
  double voxels = 1.0;
  for (int d = 0; d < 3; ++d) {
    long low = 0;
    long high = -1;
    numbers >> low >> high;
    ACUS_REQUIRE(numbers && std::labs(low) < 65536 && high >= low && high - low < 65536,
                 path.string(), ": WholeExtent '", whole, "' is not possible");
    voxels *= static_cast<double>(high - low + 1);
  }
  ACUS_REQUIRE(voxels <= static_cast<double>(MostVoxelBytes(path)), path.string(),
               ": its header "
               "promises ",
               voxels, " voxels, more than the file can hold; it is cut off or broken");
  RequireMemory(voxels, static_cast<double>(fs::file_size(path)), path.string());
}

}  // namespace

ScalarFile ReadVtiFile(const fs::path& path) {
  RequireInputFile(path);
  CheckVtiHeader(path);
  vtkObject::GlobalWarningDisplayOff();
  vtkNew<vtkXMLImageDataReader> reader;
  reader->SetFileName(path.c_str());
  reader->UpdateInformation();
  ACUS_REQUIRE(
      reader->GetErrorCode() == vtkErrorCode::NoError && reader->GetNumberOfPointArrays() >= 1,
      path.string(),
      ": has no values of points that can be read as VTK ImageData; export the volume with "
      "values of points, not of cells");
  reader->Update();
  vtkImageData* image = reader->GetOutput();
  vtkDataArray* scalars =
      image->GetPointData()->GetNumberOfArrays() > 0 ? image->GetPointData()->GetArray(0) : nullptr;
  ACUS_REQUIRE(reader->GetErrorCode() == vtkErrorCode::NoError && scalars != nullptr &&
                   scalars->GetNumberOfComponents() == 1,
               path.string(),
               ": has no number per point that can be read; export it again, with one array");
  ScalarFile file;
  const int* extent = image->GetExtent();
  Eigen::Vector3d first;
  for (int d = 0; d < 3; ++d) {
    file.geometry.size[d] = extent[2 * d + 1] - extent[2 * d] + 1;
    file.geometry.spacing_mm[d] = image->GetSpacing()[d];
    first[d] = extent[2 * d];
  }
  const double* direction = image->GetDirectionMatrix()->GetData();
  file.geometry.direction =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(direction);
  file.geometry.origin_mm = Eigen::Vector3d(image->GetOrigin());
  RequireUsable(file.geometry, path);
  file.geometry.origin_mm = file.geometry.ct_from_index() * first;
  file.type = TypeOf(scalars->GetDataType(), path);
  ACUS_REQUIRE(static_cast<std::size_t>(scalars->GetNumberOfTuples()) == file.geometry.num_voxels(),
               path.string(), ": holds ", scalars->GetNumberOfTuples(), " values for ",
               file.geometry.num_voxels(), " voxels; it is cut off or broken");
  file.bytes.resize(file.geometry.num_voxels() * BytesOf(file.type));
  std::memcpy(file.bytes.data(), scalars->GetVoidPointer(0), file.bytes.size());
  MakeRightHanded(file);
  return file;
}

}  // namespace acus::volume
