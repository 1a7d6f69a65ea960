#include "fuzz/readers.h"

#include <Eigen/Geometry>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/delimited_text.h"
#include "acus/base/core/error.h"
#include "acus/base/core/run_context.h"
#include "acus/base/core/table_sidecar.h"
#include "acus/data/mesh/surface_io.h"
#include "acus/data/session/column_csv.h"
#include "acus/data/session/perk_buffer.h"
#include "acus/data/session/plus_config.h"
#include "acus/data/session/pose_csv.h"
#include "acus/data/session/sequence_file.h"
#include "acus/data/session/sequence_writer.h"
#include "acus/data/session/session_import.h"
#include "acus/data/session/signals.h"
#include "acus/data/session/slicer_scene.h"
#include "acus/data/sound/sound.h"
#include "acus/data/transforms/landmarks.h"
#include "acus/data/transforms/transform_file.h"
#include "acus/data/volume/dicom_frame.h"
#include "acus/data/volume/dicom_header.h"
#include "acus/data/volume/dicom_segmentation.h"
#include "acus/data/volume/dicom_series.h"
#include "acus/data/volume/displacement_file.h"
#include "acus/data/volume/named_values.h"
#include "acus/data/volume/names_beside.h"
#include "acus/data/volume/scalar_file.h"
#include "acus/data/volume/structure_set.h"
#include "acus/data/volume/volume_io.h"
#include "acus/data/volume/vti_file.h"
#include "acus/imaging/rf/matlab_file.h"
#include "acus/physics/forces/laws/force_curve.h"
#include "acus/rig/camera/camera_model.h"
#include "acus/rig/tracking/igtl_wire.h"
#include "support/dicom_segmentation_writer.h"
#include "support/dicom_writer.h"
#include "support/structure_set_writer.h"

namespace acus::fuzz {
namespace {

namespace fs = std::filesystem;
using Path = const fs::path&;

void WriteSeed(Path folder, const std::string& name, std::string_view text) {
  WriteTextFile(folder / name, text);
}

volume::ScalarFile SmallVolume(int num_components) {
  volume::ScalarFile file;
  file.geometry.size = {3, 2, 2};
  file.geometry.spacing_mm = {1.0, 1.5, 2.0};
  file.type = num_components == 1 ? volume::ScalarType::kInt16 : volume::ScalarType::kFloat32;
  file.num_components = num_components;
  file.bytes.resize(12 * num_components * volume::BytesOf(file.type));
  return file;
}

void WriteVolume(Path folder, const char* extension, int num_components = 1) {
  volume::WriteScalarFile(folder / ("seed" + std::string(extension)), SmallVolume(num_components));
}

mesh::Surface Tetrahedron() {
  mesh::Surface surface;
  surface.nodes_mm = Eigen::Matrix3Xd::Zero(3, 4);
  surface.nodes_mm.rightCols<3>().setIdentity();
  surface.triangles.resize(3, 4);
  surface.triangles << 0, 0, 0, 1, 2, 1, 3, 2, 1, 3, 2, 3;
  return surface;
}

void WriteMesh(Path folder, const char* extension) {
  mesh::WriteSurface(folder / ("seed" + std::string(extension)), Tetrahedron());
}

void ReadSurfaceFile(Path file) {
  mesh::ReadSurface(file);
}
void ReadVolumeFile(Path file) {
  volume::ReadScalarFile(file);
}

// Text formats.

void ReadPreset(Path file) {
  auto document = config::ReadJson(file);
  if (!document.is_object() || !document.contains("format")) return;
  if (!document["format"].is_string()) return;
  const std::string format = document["format"];
  const std::string schema = format.substr(0, format.find('/'));
  for (const std::string& known : config::SchemaNames()) {
    if (known == schema) config::CheckedConfig(std::move(document), schema, "preset");
    if (known == schema) return;
  }
}

void WritePresets(Path folder) {
  for (const auto& entry :
       fs::recursive_directory_iterator(fs::path(ACUS_SOURCE_DIR) / "configs")) {
    const bool is_preset =
        entry.path().extension() == ".json" && entry.path().parent_path().filename() != "schema";
    if (is_preset) WriteSeed(folder, entry.path().filename(), ReadTextFile(entry.path()));
  }
}

constexpr std::string_view kPoses =
    "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,status\n"
    "0,1,2,3,1,0,0,0,OK\n0.001,1,2,3,0,1,0,0,INVALID\n0.002,1,2,-3e1,1,0,0,0,OK\n";
constexpr std::string_view kPerk =
    "<TransformRecorderLog>\n<log TimeStampSec=\"7\" TimeStampNSec=\"256000000\" "
    "type=\"transform\" DeviceName=\"ProbeToRAS\" transform=\"1 0 0 1 0 1 0 2 0 0 1 3 0 0 0 1\" />"
    "\n<log TimeStampSec=\"8\" TimeStampNSec=\"0\" type=\"message\" message=\"end\"/>"
    "</TransformRecorderLog>";
constexpr std::string_view kScene =
    "<?xml version=\"1.0\"?>\n<!-- a scene -->\n<MRML version=\"Slicer4.4.0\">\n"
    "<LinearTransform id=\"now\" name=\"NeedleToReference\" "
    "matrixTransformToParent=\"1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\" />\n"
    "<Sequence id=\"seq\" name=\"S\" storageNodeRef=\"s\" indexUnit=\"s\" indexValues=\"0;1\" />\n"
    "</MRML>\n";
constexpr std::string_view kPlus =
    "<PlusConfiguration version=\"2.1\"><CoordinateDefinitions><Transform From=\"Image\" "
    "To=\"Probe\" Matrix=\"0.1 0 0 5 0 0.2 0 6 0 0 0.1 7 0 0 0 1\" />"
    "</CoordinateDefinitions></PlusConfiguration>\n";
constexpr const char* kMachine =
    "\"Specimen\";\"A;1\"\n\nTime;Extension;Load\n(ms);(mm);(kN)\n0;0;0,1\n1,5;0,5;\n2;\"1,0\";0,"
    "3\n";
constexpr std::string_view kForces =
    "time_s,depth_mm,force_n\n0,0,0\n0.1,1,0.1\n0.2,2,0.2\n0.3,3,0.1\n0.4,4,0.2\n";
constexpr std::string_view kMarkups =
    R"({"markups": [{"type": "Fiducial", "coordinateSystem": "RAS", "coordinateUnits": "mm",
"controlPoints": [{"label": "a", "position": [1, 2, 3], "positionStatus": "defined"}]}]})";

void WriteSequence(Path folder, const char* name) {
  session::SequenceWriter writer(folder / name, {.width = 2, .height = 2});
  for (int frame = 0; frame < 2; ++frame) {
    session::SequenceFields fields;
    session::AddTransform(fields, "NeedleToReference", Eigen::Matrix4d::Identity(), true);
    const std::vector<std::uint8_t> pixels(4, 7);
    writer.AddFrame(frame * 1'000'000, pixels, fields);
  }
  writer.Commit();
}

void ReadSequence(Path file) {
  session::ReadPlusSession(file, {}, RunContext{});
  session::SequenceFile sequence(file);
  for (std::size_t frame = 0; sequence.has_images() && frame < sequence.num_frames(); ++frame) {
    sequence.ReadImageMarkedFar(frame);
  }
}

/// A header and its body, as they come over the network.
void ReadMessage(Path file) {
  const std::string text = ReadTextFile(file);
  const tracking::ByteView bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  if (bytes.size() < tracking::kIgtlHeaderBytes) return;
  const auto header = tracking::ParseHeader(bytes.first(tracking::kIgtlHeaderBytes));
  if (!header) return;
  const auto body = tracking::SplitBody(*header, bytes.subspan(tracking::kIgtlHeaderBytes));
  if (!body) return;
  tracking::SaysValid(body->metadata);
  tracking::ReadTransform(body->content);
  tracking::ReadPosition(body->content);
  tracking::ReadTrackingData(body->content);
  tracking::ReadQuaternionTrackingData(body->content);
  tracking::ReadStartTrackingData(body->content);
  tracking::ReadStatus(body->content);
  tracking::ReadImage(body->content);
  tracking::ReadTable(body->content);
  tracking::ReadText(body->content);
}

void WriteMessages(Path folder) {
  const auto bytes = tracking::PackTransform("NeedleToReference", 1'000'000'000, {});
  WriteSeed(folder, "transform", {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  const auto table =
      tracking::PackTable("Steps", 1'000'000'000, {.columns = 2, .values = {1.0, 2.0, 3.0, 4.0}});
  WriteSeed(folder, "table", {reinterpret_cast<const char*>(table.data()), table.size()});
}

void WriteChannels(Path folder) {
  rf::ChannelData data;
  data.samples = 4;
  data.elements = 2;
  data.transmits = 1;
  data.sampling_mhz = 40.0;
  data.Allocate();
  rf::WriteMatlab(folder / "seed.mat", data);
}

void WriteSegmentation(Path folder) {
  testing_support::DicomSegObject object;
  object.segments = {{.label = "Liver", .code = "10200004", .side_code = ""},
                     {.label = "Kidney", .code = "64033007", .side_code = "7771000"}};
  object.frames = {{1, {5, 6, 10}, {1, 0, 0, 0, 0, 0, 0, 0, 1}},
                   {2, {5, 6, 14}, {0, 1, 0, 0, 0, 0, 0, 0, 0}}};
  testing_support::WriteDicomSegmentation(folder / "seed.dcm", object);
}

volume::Geometry SmallCtGrid() {
  volume::Geometry grid;
  grid.size = {8, 8, 4};
  grid.spacing_mm = {2.0, 2.0, 3.0};
  return grid;
}

void WriteContours(Path folder) {
  testing_support::WriteStructureSet(
      folder / "seed.dcm",
      {{.name = "Liver",
        .contours = {{{1, 1, 3}, {9, 1, 3}, {9, 9, 3}}, {{1, 1, 6}, {9, 1, 6}, {9, 9, 6}}}},
       {.name = "PTV", .type = "PTV", .contours = {{{1, 1, 3}, {5, 1, 3}, {5, 9, 3}}}},
       {.name = "GTV", .contours = {{{1, 1, 3}, {5, 1, 3}, {5, 9, 3}}}, .frame_uid = "1.3"}},
      {.frame_uid = "1.2", .series_uid = "1.9"});
}

/// Two volumes over time: four dimensions in the header of one.
void WriteSeries(Path folder) {
  WriteVolume(folder, ".nii");
  std::string bytes = ReadTextFile(folder / "seed.nii");
  bytes[40] = 4;
  bytes[48] = 2;
  WriteSeed(folder, "seed.nii", bytes + bytes.substr(352));
}

constexpr std::string_view kVtk =
    "# vtk DataFile Version 4.2\nsurface SPACE=RAS\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n"
    "0 0 0 1 0 0 0 1 0 0 0 1\nPOLYGONS 4 16\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";

// The same needle in the exports of two trackers, and mappings of their columns.

constexpr std::string_view kMotive =
    "Format Version,1.23,Length Units,Meters\n\n,,RigidBody,RigidBody,RigidBody,RigidBody,"
    "RigidBody,RigidBody,RigidBody\n,Name,Needle,Needle,Needle,Needle,Needle,Needle,Needle\n"
    ",,\"A1\",\"A1\",\"A1\",\"A1\",\"A1\",\"A1\",\"A1\"\n,,Rotation,Rotation,Rotation,Rotation,"
    "Position,Position,Position\nFrame,Time (Seconds),X,Y,Z,W,X,Y,Z\n"
    "0,0.0,0,0,0,1,0.1,0.2,0.3\n1,0.1,0,0,0,1,0.2,0.2,0.3\n2,0.2,,,,,,,\n";
constexpr std::string_view kTum =
    "# timestamp tx ty tz qx qy qz qw\n1.0 0.1 0.2 0.3 0 0 0 1\n1.1 0.2 0.2 0.3 0 0 0 1\n";
constexpr std::string_view kMotiveColumns =
    R"json({"format": "acus-columns/1", "name": "m", "header_rows": [4, 6, 7], "first_row": 8,
"length_unit": "m", "time": {"column": "Name/Time (Seconds)"}, "tools": [{"tool": "needle",
"position": ["Needle/Position/X", "Needle/Position/Y", "Needle/Position/Z"],
"rotation": ["Needle/Rotation/W", "Needle/Rotation/X", "Needle/Rotation/Y",
"Needle/Rotation/Z"]}]})json";
constexpr std::string_view kTumColumns =
    R"({"format": "acus-columns/1", "name": "t", "first_row": 1, "length_unit": "m",
"time": {"column": 1}, "tools": [{"tool": "needle", "position": [2, 3, 4],
"rotation": [8, 5, 6, 7]}]})";

/// A file of fixed content in a folder beside the one that is made up.
fs::path Beside(Path file, const char* name, std::string_view text) {
  const fs::path folder = file.parent_path() / "beside";
  fs::create_directory(folder);
  if (!fs::exists(folder / name)) WriteTextFile(folder / name, text);
  return folder / name;
}

/// The mapping is checked once: against a schema, that takes ten times as long as the table.
nlohmann::json Mapping(std::string_view text) {
  return config::CheckedConfig(nlohmann::json::parse(text), "acus-columns", "mapping");
}

void ReadMotive(Path file) {
  static const nlohmann::json kMapping = Mapping(kMotiveColumns);
  session::ReadMappedCsv(file, kMapping, true, RunContext{});
}
void ReadTum(Path file) {
  static const nlohmann::json kMapping = Mapping(kTumColumns);
  session::ReadMappedCsv(file, kMapping, true, RunContext{});
}
void ReadColumns(Path file) {
  const fs::path table = Beside(file, "motive.csv", kMotive);
  session::ReadColumnCsv(table, file, false, RunContext{});
}

/// The description of a table, "Columns" and units of which are used.
void ReadSidecar(Path file) {
  fs::path table = file;
  SidecarOf(table.replace_extension(".tsv"));
}

constexpr std::string_view kSidecar =
    R"({"Columns": ["depth", "force"], "SamplingFrequency": 100, "StartTime": -1.5,
"depth": {"Units": "mm"}, "force": {"Units": "N", "Description": "axial"}})";

// Names of the values of label maps.

constexpr std::string_view kItkSnap =
    "# ITK-SnAP Label Description File\n0 0 0 0 0 0 0 \"Clear Label\"\n"
    "1 255 0 0 1 1 1 \"liver\"\n2 0 255 0 0.5 1 0 \"Kidney, left\"\n";
constexpr std::string_view kColours =
    "# Color table file a.ctbl\n# 3 values\n0 Background 0 0 0 0\n1 liver 221 130 101 255\n"
    "17 rib left 1 20 30 40 255\n3: spleen\n";
constexpr std::string_view kLabelColumns =
    "LabelValue,Name,Color_R,Type_CodingScheme,Type_CodeValue,TypeModifier_CodingScheme,"
    "TypeModifier_CodeValue\n1,liver,10,SCT,10200004,,\n2,\"kidney, left\",20,SCT,64033007,SCT,"
    "7771000\n";
constexpr std::string_view kDataset =
    R"({"name": "a", "labels": {"background": 0, "liver": 1, "spleen": 2}})";
constexpr std::string_view kStack =
    R"({"type": "org.mitk.multilabel.segmentation.stack", "version": 3, "groups": [{"_file":
"./input.nii", "labels": [{"name": "liver", "value": 1, "_file": "./a.nii", "_file_value": 1}]}]})";
constexpr std::string_view kDcmqi =
    R"({"segmentAttributes": [[{"labelID": 1, "SegmentLabel": "x",
"SegmentedPropertyTypeCodeSequence": {"CodeValue": "64033007"},
"SegmentedPropertyTypeModifierCodeSequence": {"CodeValue": "7771000"}}]]})";

void WriteNames(Path folder) {
  WriteSeed(folder, "dataset.json", kDataset);
  WriteSeed(folder, "stack.json", kStack);
  WriteSeed(folder, "dcmqi.json", kDcmqi);
  WriteSeed(folder, "list.json", R"({"labels": [{"value": 7, "name": "colon"}]})");
  WriteSeed(folder, "objects.json", R"({"7": {"name": "stomach", "color": [1, 2, 3]}})");
}

/// Two groups of MITK, the second of which is described by XML.
void WriteMitk(Path folder) {
  volume::ScalarFile file = SmallVolume(2);
  file.type = volume::ScalarType::kUint8;
  file.bytes.resize(24);
  file.keys = {{"org.mitk.multilabel.segmentation.labelgroups",
                R"([{"labels": [{"name": "liver", "value": 1}]}])"},
               {"org_mitk_label_001_00001",
                "<Label><property key=\"name\"><string value=\"a\"/></property>"
                "<property key=\"value\"><unsigned value=\"1\"/></property></Label>"}};
  volume::WriteScalarFile(folder / "seed.nrrd", file);
}

// Calibrations of OpenCV and ROS.

constexpr std::string_view kOpenCvCamera =
    "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\ncamera_matrix: !!opencv-matrix\n"
    "   rows: 3\n   cols: 3\n   dt: d\n   data: [ 500., 0., 320., 0., 500., 240., 0., 0., 1. ]\n"
    "distortion_coefficients: !!opencv-matrix\n   rows: 5\n   cols: 1\n   dt: d\n"
    "   data: [ -0.1, 0.05, 0.001, -0.001, 0. ]\n";
constexpr std::string_view kRosCamera =
    "image_width: 640\nimage_height: 480\ncamera_name: head\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
    "  data: [500, 0, 320, 0, 500, 240, 0, 0, 1]\ndistortion_model: plumb_bob\n"
    "distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [-0.1, 0.05, 0, 0, 0]\n";
constexpr std::string_view kXmlCamera =
    "<?xml version=\"1.0\"?>\n<opencv_storage>\n<image_width>640</image_width>\n"
    "<image_height>480</image_height>\n<camera_matrix type_id=\"opencv-matrix\">\n<rows>3</rows>"
    "<cols>3</cols><dt>d</dt><data>500. 0. 320. 0. 500. 240. 0. 0. 1.</data></camera_matrix>\n"
    "<distortion_coefficients type_id=\"opencv-matrix\"><rows>4</rows><cols>1</cols><dt>d</dt>"
    "<data>-0.1 0.05 0. 0.</data></distortion_coefficients>\n</opencv_storage>\n";

void ReadCameraFile(Path file) {
  camera::ReadCamera(file);
}

constexpr std::string_view kComposite =
    "#Insight Transform File V1.0\n#Transform 0\nTransform: CompositeTransform_double_3_3\n"
    "#Transform 1\nTransform: Euler3DTransform_double_3_3\nParameters: 0.1 0.2 0.3 1 2 3\n"
    "FixedParameters: 4 5 6 0\n#Transform 2\nTransform: AffineTransform_double_3_3\n"
    "Parameters: 1 0 0 0 1 0 0 0 1 7 8 9\nFixedParameters: 0 0 0\n";

/// Two slices in a folder, one of which is made up.
void ReadSlices(Path file) {
  const fs::path folder = file.parent_path() / "slices";
  fs::create_directory(folder);
  const fs::path second = folder / "b.dcm";
  if (!fs::exists(second)) {
    testing_support::WriteDicomSlice(second, {.columns = 4,
                                              .rows = 3,
                                              .position_mm = {0, 0, 2},
                                              .stored = std::vector<std::int16_t>(12)});
  }
  fs::remove(folder / "a.dcm");
  fs::create_hard_link(file, folder / "a.dcm");
  volume::ReadDicomCt(folder, "", RunContext{});
}

void WriteSlice(Path folder) {
  testing_support::WriteDicomSlice(
      folder / "seed.dcm", {.columns = 4, .rows = 3, .stored = std::vector<std::int16_t>(12, 7)});
}

/// NIfTI-2, after the header of a NIfTI-1 file.
void WriteNifti2(Path folder) {
  WriteVolume(folder, ".nii");
  const std::string old = ReadTextFile(folder / "seed.nii");
  fs::remove(folder / "seed.nii");
  std::string head(544, '\0');
  const auto put = [&head](std::size_t at, const auto& value) {
    std::memcpy(head.data() + at, &value, sizeof(value));
  };
  put(0, std::int32_t{540});
  head.replace(4, 8, std::string("n+2\0\r\n\x1a\n", 8));
  put(12, std::int16_t{4});
  put(14, std::int16_t{16});
  const std::int64_t sizes[] = {3, 3, 2, 2, 1, 1, 1, 1};
  for (std::size_t n = 0; n < 8; ++n) put(16 + 8 * n, sizes[n]);
  const double spacings[] = {1, 1, 1.5, 2, 1, 1, 1, 1};
  for (std::size_t n = 0; n < 8; ++n) put(104 + 8 * n, spacings[n]);
  put(168, std::int64_t{544});
  put(176, 1.0);
  put(348, std::int32_t{1});
  const double rows[] = {1, 0, 0, 0, 0, 1.5, 0, 0, 0, 0, 2, 0};
  for (std::size_t n = 0; n < 12; ++n) put(400 + 8 * n, rows[n]);
  put(500, std::int32_t{2});
  WriteSeed(folder, "seed.nii", head + old.substr(352));
}

/// Two segments in two layers.
void WriteSegments(Path folder) {
  volume::ScalarFile file = SmallVolume(2);
  file.type = volume::ScalarType::kUint8;
  file.bytes.resize(24);
  file.keys = {{"Segment0_ID", "a"},         {"Segment0_Layer", "0"},
               {"Segment0_LabelValue", "1"}, {"Segment0_Name", "liver"},
               {"Segment1_ID", "b"},         {"Segment1_Layer", "1"},
               {"Segment1_LabelValue", "1"}, {"Segment1_Name", "tumour"}};
  volume::WriteScalarFile(folder / "seed.seg.nrrd", file);
}

constexpr Reader kReaders[] = {
    {"preset", ".json", ReadPreset, WritePresets},
    {"csv_table", ".csv",
     [](Path file) {
       const CsvTable table(file);
       for (const std::string& column : table.columns()) table.Numbers(column);
     },
     [](Path folder) { WriteSeed(folder, "seed.csv", kForces); }},
    {"nrrd", ".nrrd", ReadVolumeFile, [](Path folder) { WriteVolume(folder, ".nrrd"); }},
    {"meta_image", ".mha", ReadVolumeFile, [](Path folder) { WriteVolume(folder, ".mha"); }},
    {"nifti", ".nii", ReadVolumeFile, [](Path folder) { WriteVolume(folder, ".nii"); }},
    {"label_map", ".seg.nrrd", [](Path file) { volume::ReadTissues(file); },
     [](Path folder) { WriteVolume(folder, ".nrrd"); }},
    {"displacement_field", ".mha", [](Path file) { volume::ReadDisplacementField(file); },
     [](Path folder) { WriteVolume(folder, ".mha", 3); }},
    {"dicom_header", ".dcm", [](Path file) { volume::ReadDicomHeader(file); },
     [](Path folder) {
       WriteSeed(folder, "seed.dcm",
                 std::string(128, '\0') + "DICM" +
                     std::string("\x02\x00\x10\x00UI\x04\x00"
                                 "1.2\0",
                                 12));
     }},
    {"dicom_segmentation", ".dcm", [](Path file) { volume::ReadDicomSegmentation(file); },
     WriteSegmentation},
    {"structure_set", ".dcm",
     [](Path file) {
       volume::FrameOfLabels(file);
       volume::ReadStructureSet(file, SmallCtGrid(), {"1.2"});
     },
     WriteContours},
    {"nifti_2", ".nii", ReadVolumeFile, WriteNifti2},
    {"dicom_slices", ".dcm", ReadSlices, WriteSlice},
    {"nifti_series", ".nii", [](Path file) { volume::ReadVolumeOf(file, 1); }, WriteSeries},
    {"legacy_vtk", ".vtk", ReadSurfaceFile,
     [](Path folder) { WriteSeed(folder, "seed.vtk", kVtk); }},
    {"landmarks_fcsv", ".fcsv", [](Path file) { transforms::ReadLandmarks(file); },
     [](Path folder) {
       WriteSeed(folder, "seed.fcsv",
                 "# CoordinateSystem = RAS\n# columns = "
                 "id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n"
                 "1,1,2,3,0,0,0,1,1,1,0,\"a, "
                 "b\",,\n2,4,2,3,0,0,0,1,1,1,0,c,,\n3,1,8,3,0,0,0,1,1,1,0,d,,\n");
     }},
    {"label_description", ".txt", [](Path file) { volume::NamesInFile(file); },
     [](Path folder) {
       WriteSeed(folder, "snap.txt", kItkSnap);
       WriteSeed(folder, "colours.txt", kColours);
     }},
    {"label_columns", ".csv", [](Path file) { volume::NamesInFile(file); },
     [](Path folder) { WriteSeed(folder, "seed.csv", kLabelColumns); }},
    {"label_names", ".json", [](Path file) { volume::NamesInFile(file); }, WriteNames},
    {"label_groups", ".nrrd", [](Path file) { volume::ReadNamedValues(file); }, WriteMitk},
    {"segments", ".seg.nrrd", [](Path file) { volume::ReadNamedValues(file); }, WriteSegments},
    {"wav", ".wav", [](Path file) { sound::ReadSound(file); },
     [](Path folder) {
       sound::WriteWav(folder / "seed.wav", {.rate_hz = 8000, .samples = {1, 2, 3, 4}});
     }},
    {"stl", ".stl", ReadSurfaceFile, [](Path folder) { WriteMesh(folder, ".stl"); }},
    {"obj", ".obj", ReadSurfaceFile, [](Path folder) { WriteMesh(folder, ".obj"); }},
    {"ply", ".ply", ReadSurfaceFile, [](Path folder) { WriteMesh(folder, ".ply"); }},
    {"transform", ".tfm", [](Path file) { transforms::ReadTransform(file); },
     [](Path folder) {
       transforms::WriteTransform(folder / "seed.tfm", Eigen::Isometry3d::Identity(), "seed");
     }},
    {"transform_composite", ".tfm", [](Path file) { transforms::ReadTransform(file); },
     [](Path folder) { WriteSeed(folder, "seed.tfm", kComposite); }},
    {"landmarks_csv", ".csv", [](Path file) { transforms::ReadLandmarks(file); },
     [](Path folder) {
       WriteSeed(folder, "seed.csv", "name,x_mm,y_mm,z_mm\na,1,2,3\nb,4,5,-6\n");
     }},
    {"landmarks_markups", ".mrk.json", [](Path file) { transforms::ReadLandmarks(file); },
     [](Path folder) { WriteSeed(folder, "seed.mrk.json", kMarkups); }},
    {"poses_csv", ".csv", [](Path file) { session::ReadPoseCsv(file, RunContext{}); },
     [](Path folder) { WriteSeed(folder, "seed.csv", kPoses); }},
    {"breath_csv", ".csv", [](Path file) { session::ReadBreathCsv(file, RunContext{}); },
     [](Path folder) { WriteSeed(folder, "seed.csv", "time_s,level\n0,0\n0.1,0.5\n"); }},
    {"commands_csv", ".csv", [](Path file) { session::ReadCommandsCsv(file, RunContext{}); },
     [](Path folder) { WriteSeed(folder, "seed.csv", "time_s,command,value\n0,gain_db,1\n"); }},
    {"sequence_meta_image", ".igs.mha", ReadSequence,
     [](Path folder) { WriteSequence(folder, "seed.igs.mha"); }},
    {"sequence_nrrd", ".igs.nrrd", ReadSequence,
     [](Path folder) { WriteSequence(folder, "seed.igs.nrrd"); }},
    {"slicer_scene", ".mrml", [](Path file) { session::ReadSlicerScene(file); },
     [](Path folder) { WriteSeed(folder, "seed.mrml", kScene); }},
    {"perk_buffer", ".xml", [](Path file) { session::ReadPerkBuffer(file); },
     [](Path folder) { WriteSeed(folder, "seed.xml", kPerk); }},
    {"plus_config", ".xml", [](Path file) { session::ReadPlusCalibrations(file); },
     [](Path folder) { WriteSeed(folder, "seed.xml", kPlus); }},
    {"force_curve", ".csv", [](Path file) { forces::ReadForceCurve(file); },
     [](Path folder) { WriteSeed(folder, "seed.csv", kForces); }},
    {"machine_table", ".csv", [](Path file) { forces::ReadForceCurve(file); },
     [](Path folder) { WriteSeed(folder, "seed.csv", kMachine); }},
    {"plain_table", ".csv", [](Path file) { AsPlainCsv(ReadTextFile(file), file.string()); },
     [](Path folder) { WriteSeed(folder, "seed.csv", kMachine); }},
    {"motive_csv", ".csv", ReadMotive, [](Path folder) { WriteSeed(folder, "seed.csv", kMotive); }},
    {"tum_poses", ".txt", ReadTum, [](Path folder) { WriteSeed(folder, "seed.txt", kTum); }},
    {"columns_mapping", ".json", ReadColumns,
     [](Path folder) { WriteSeed(folder, "seed.json", kMotiveColumns); }},
    {"table_sidecar", ".json", ReadSidecar,
     [](Path folder) { WriteSeed(folder, "seed.json", kSidecar); }},
    {"camera_opencv", ".yml", ReadCameraFile,
     [](Path folder) { WriteSeed(folder, "seed.yml", kOpenCvCamera); }},
    {"camera_ros", ".yaml", ReadCameraFile,
     [](Path folder) { WriteSeed(folder, "seed.yaml", kRosCamera); }},
    {"camera_xml", ".xml", ReadCameraFile,
     [](Path folder) { WriteSeed(folder, "seed.xml", kXmlCamera); }},
    {"channel_data", ".mat", [](Path file) { rf::ReadMatlab(file, ""); }, WriteChannels},
    {"tracker_message", ".bin", ReadMessage, WriteMessages},
};

}  // namespace

std::span<const Reader> Readers() {
  return kReaders;
}

void ReadOrRefuse(const Reader& reader, const fs::path& file) {
  try {
    reader.read(file);
  } catch (const InputError&) {  // An answer, too.
  }
}

}  // namespace acus::fuzz
