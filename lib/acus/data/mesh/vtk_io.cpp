#include "acus/data/mesh/vtk_io.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <vtkCell.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkPolyDataReader.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLPolyDataReader.h>
#include <vtkXMLPolyDataWriter.h>
#include <vtkXMLUnstructuredGridReader.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include "acus/base/core/child_process.h"
#include "acus/base/core/input_file.h"
#include "acus/data/mesh/packed_mesh.h"

namespace acus::mesh {
namespace {

constexpr double kReadTimeS = 120.0;

vtkSmartPointer<vtkPoints> PointsOf(const Eigen::Matrix3Xd& nodes_mm) {
  auto points = vtkSmartPointer<vtkPoints>::New();
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(nodes_mm.cols());
  for (Eigen::Index n = 0; n < nodes_mm.cols(); ++n) points->SetPoint(n, nodes_mm.col(n).data());
  return points;
}

std::vector<double> NodesOf(vtkPointSet& data) {
  const vtkIdType count = data.GetNumberOfPoints();
  ACUS_REQUIRE(count > 0 && data.GetPoints() != nullptr, "it holds no point");
  std::vector<double> out(static_cast<std::size_t>(count) * 3);
  for (vtkIdType n = 0; n < count; ++n) data.GetPoint(n, out.data() + 3 * n);
  for (const double value : out) ACUS_REQUIRE(std::isfinite(value), "a coordinate is not finite");
  return out;
}

/// Reads the file; every complaint of VTK counts.
template <typename Reader>
void ReadFile(Reader& reader, const std::filesystem::path& path) {
  reader.SetFileName(path.c_str());
  reader.Update();
  ACUS_REQUIRE(reader.GetErrorCode() == 0 && reader.GetOutput() != nullptr,
               "it is cut off, broken, or of another kind than its extension says");
}

int CheckedNode(vtkIdType node, vtkIdType count) {
  ACUS_REQUIRE(node >= 0 && node < count, "a cell names point ", node, ", but there are ", count);
  return static_cast<int>(node);
}

/// A surface of polygons or strips of triangles.
template <typename Reader>
std::string LoadSurface(const std::filesystem::path& path) {
  vtkNew<Reader> reader;
  ReadFile(*reader, path);
  vtkPolyData& data = *reader->GetOutput();
  const std::vector<double> nodes = NodesOf(data);
  std::vector<int> triangles;
  vtkIdType size = 0;
  const vtkIdType* corners = nullptr;
  vtkCellArray* polygons = data.GetPolys();
  for (polygons->InitTraversal(); polygons->GetNextCell(size, corners) != 0;) {
    for (vtkIdType i = 2; i < size; ++i) {
      for (const vtkIdType corner : {corners[0], corners[i - 1], corners[i]}) {
        triangles.push_back(CheckedNode(corner, data.GetNumberOfPoints()));
      }
    }
  }
  vtkCellArray* strips = data.GetStrips();
  for (strips->InitTraversal(); strips->GetNextCell(size, corners) != 0;) {
    for (vtkIdType i = 2; i < size; ++i) {  // Every second one turns the other way.
      const bool is_odd = i % 2 == 1;
      for (const vtkIdType corner :
           {corners[i - 2], corners[is_odd ? i : i - 1], corners[is_odd ? i - 1 : i]}) {
        triangles.push_back(CheckedNode(corner, data.GetNumberOfPoints()));
      }
    }
  }
  ACUS_REQUIRE(!triangles.empty(), "it holds no polygon");
  core::ByteWriter out(kPackedOrder);
  out.Array(std::span<const double>(nodes));
  out.Array(std::span<const int>(triangles));
  return out.AsString();
}

std::vector<std::uint8_t> Flags(vtkDataArray* array, std::size_t count, std::uint8_t without) {
  std::vector<std::uint8_t> out(count, without);
  if (array == nullptr) return out;
  ACUS_REQUIRE(static_cast<std::size_t>(array->GetNumberOfTuples()) == count, "its array '",
               array->GetName(), "' has ", array->GetNumberOfTuples(), " values instead of ",
               count);
  for (std::size_t i = 0; i < count; ++i) {
    const double value = array->GetComponent(static_cast<vtkIdType>(i), 0);
    ACUS_REQUIRE(value >= 0 && value <= 255, "its array '", array->GetName(), "' holds ", value);
    out[i] = static_cast<std::uint8_t>(value);
  }
  return out;
}

std::string LoadTetraMesh(const std::filesystem::path& path) {
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  ReadFile(*reader, path);
  vtkUnstructuredGrid& data = *reader->GetOutput();
  const std::vector<double> nodes = NodesOf(data);
  const auto num_cells = static_cast<std::size_t>(data.GetNumberOfCells());
  ACUS_REQUIRE(num_cells > 0, "it holds no cell");
  std::vector<int> tetrahedra;
  tetrahedra.reserve(4 * num_cells);
  for (vtkIdType c = 0; c < data.GetNumberOfCells(); ++c) {
    ACUS_REQUIRE(data.GetCellType(c) == VTK_TETRA, "cell ", c, " is not a tetrahedron");
    vtkIdType size = 0;
    const vtkIdType* corners = nullptr;
    data.GetCellPoints(c, size, corners);
    ACUS_REQUIRE(size == 4, "cell ", c, " has ", size, " corners");
    for (int i = 0; i < 4; ++i) {
      tetrahedra.push_back(CheckedNode(corners[i], data.GetNumberOfPoints()));
    }
  }
  vtkDataArray* tissue_array = data.GetCellData()->GetArray("tissue");
  const auto tissue = Flags(tissue_array, tissue_array == nullptr ? 0 : num_cells, 0);
  const auto fixed = Flags(data.GetPointData()->GetArray("fixed"), nodes.size() / 3, 0);
  core::ByteWriter out(kPackedOrder);
  out.Array(std::span<const double>(nodes));
  out.Array(std::span<const int>(tetrahedra));
  out.Array(std::span<const std::uint8_t>(tissue));
  out.Array(std::span<const std::uint8_t>(fixed));
  return out.AsString();
}

std::string Load(const std::filesystem::path& path,
                 std::string (*load)(const std::filesystem::path&)) {
  const auto bytes = static_cast<double>(RequireInputFile(path));
  core::ChildLimits limits;
  limits.time_s = kReadTimeS;
  // A compressed file may unpack to far more than its size, but not to everything there is.
  limits.memory_bytes = std::min(1e9 + 100.0 * bytes, 1e9 + InputMemoryBytes());
  core::ChildResult result = core::RunInChild([&] { return load(path); }, limits);
  ACUS_REQUIRE(result.end == core::ChildResult::End::kDone, path.string(), ": cannot be used: ",
               result.end == core::ChildResult::End::kThrew
                   ? result.problem
                   : "the file is broken (" + result.problem + ")");
  return std::move(result.bytes);
}

Surface SurfaceFrom(const std::string& bytes) {
  core::ByteReader in(bytes, kPackedOrder);
  Surface out;
  out.nodes_mm = TakeColumns<double, 3>(in);
  out.triangles = TakeColumns<int, 3>(in);
  return out;
}

vtkSmartPointer<vtkUnsignedCharArray> ArrayOf(const char* name,
                                              const std::vector<std::uint8_t>& values) {
  auto array = vtkSmartPointer<vtkUnsignedCharArray>::New();
  array->SetName(name);
  array->SetNumberOfTuples(static_cast<vtkIdType>(values.size()));
  for (std::size_t i = 0; i < values.size(); ++i) {
    array->SetValue(static_cast<vtkIdType>(i), values[i]);
  }
  return array;
}

}  // namespace

Surface ReadVtp(const std::filesystem::path& path) {
  return SurfaceFrom(Load(path, LoadSurface<vtkXMLPolyDataReader>));
}

Surface ReadLegacyVtk(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string head, title;
  std::getline(file, head);
  std::getline(file, title);
  ACUS_REQUIRE(head.starts_with("# vtk DataFile"), path.string(),
               ": does not begin with '# vtk DataFile'; it is no legacy VTK file");
  Surface surface = SurfaceFrom(Load(path, LoadSurface<vtkPolyDataReader>));
  // 3D Slicer says in the title in which space the points are; LPS is ours.
  if (title.find("SPACE=RAS") != title.npos) surface.nodes_mm.topRows<2>() *= -1.0;
  return surface;
}

TetraMesh ReadVtu(const std::filesystem::path& path) {
  const std::string bytes = Load(path, LoadTetraMesh);
  core::ByteReader in(bytes, kPackedOrder);
  TetraMesh out;
  out.nodes_mm = TakeColumns<double, 3>(in);
  out.tetrahedra = TakeColumns<int, 4>(in);
  out.tissue = in.Array<std::uint8_t>();
  out.fixed_nodes = in.Array<std::uint8_t>();
  ACUS_ASSERT(in.ok());
  return out;
}

void WriteVtp(const std::filesystem::path& path, const Surface& surface) {
  vtkObject::GlobalWarningDisplayOff();  // A full disk is reported by the exception alone.
  vtkNew<vtkPolyData> data;
  data->SetPoints(PointsOf(surface.nodes_mm));
  vtkNew<vtkCellArray> triangles;
  for (Eigen::Index t = 0; t < surface.triangles.cols(); ++t) {
    const Eigen::Matrix<vtkIdType, 3, 1> corners = surface.triangles.col(t).cast<vtkIdType>();
    triangles->InsertNextCell(3, corners.data());
  }
  data->SetPolys(triangles);
  vtkNew<vtkXMLPolyDataWriter> writer;
  writer->SetInputData(data);
  writer->SetFileName(path.c_str());
  ACUS_REQUIRE(writer->Write() == 1, path.string(), ": cannot be written; is the disk full?");
}

void WriteVtu(const std::filesystem::path& path, const TetraMesh& mesh) {
  vtkObject::GlobalWarningDisplayOff();
  vtkNew<vtkUnstructuredGrid> data;
  data->SetPoints(PointsOf(mesh.nodes_mm));
  vtkNew<vtkCellArray> cells;
  for (Eigen::Index t = 0; t < mesh.tetrahedra.cols(); ++t) {
    const Eigen::Matrix<vtkIdType, 4, 1> corners = mesh.tetrahedra.col(t).cast<vtkIdType>();
    cells->InsertNextCell(4, corners.data());
  }
  data->SetCells(VTK_TETRA, cells);
  data->GetCellData()->AddArray(ArrayOf("tissue", mesh.tissue));
  data->GetCellData()->SetActiveScalars("tissue");
  data->GetPointData()->AddArray(ArrayOf("fixed", mesh.fixed_nodes));
  vtkNew<vtkXMLUnstructuredGridWriter> writer;
  writer->SetInputData(data);
  writer->SetFileName(path.c_str());
  ACUS_REQUIRE(writer->Write() == 1, path.string(), ": cannot be written; is the disk full?");
}

}  // namespace acus::mesh
