#include "acus/physics/breathing/motion_file.h"

#include <bit>
#include <fstream>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/base/core/input_file.h"

namespace acus::breathing {
namespace {

using nlohmann::json;
static_assert(std::endian::native == std::endian::little, "fields.raw is little endian");

json JsonOf(const volume::Geometry& nodes) {
  json direction = json::array();
  for (Eigen::Index row = 0; row < 3; ++row) {
    for (Eigen::Index column = 0; column < 3; ++column) {
      direction.push_back(nodes.direction(row, column));
    }
  }
  const auto triple = [](const auto& v) { return json::array({v[0], v[1], v[2]}); };
  return {{"size", triple(nodes.size)},
          {"spacing_mm", triple(nodes.spacing_mm)},
          {"origin_mm", triple(nodes.origin_mm)},
          {"direction", direction}};
}

volume::Geometry NodesOf(const json& document, const std::filesystem::path& path) {
  volume::Geometry nodes;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const auto n = static_cast<std::size_t>(axis);
    nodes.size[axis] = document.at("size").at(n).get<int>();
    nodes.spacing_mm[axis] = document.at("spacing_mm").at(n).get<double>();
    nodes.origin_mm[axis] = document.at("origin_mm").at(n).get<double>();
    for (Eigen::Index column = 0; column < 3; ++column) {
      nodes.direction(axis, column) =
          document.at("direction").at(static_cast<std::size_t>(3 * axis + column)).get<double>();
    }
  }
  const Eigen::Matrix3d off =
      nodes.direction.transpose() * nodes.direction - Eigen::Matrix3d::Identity();
  ACUS_REQUIRE(off.cwiseAbs().maxCoeff() < 1e-6, path.string(),
               ": /nodes/direction: its columns are not perpendicular unit vectors");
  return nodes;
}

/// A NRRD header that points to the raw file: Python and 3D Slicer read it as it is.
std::string NrrdHeader(const MotionField& field) {
  const volume::Geometry& nodes = field.nodes();
  std::string text = "NRRD0005\ntype: int16\ndimension: 5\nspace: left-posterior-superior\n";
  text += Message("sizes: 3 ", nodes.size[0], " ", nodes.size[1], " ", nodes.size[2], " ",
                  field.num_components(), "\nkinds: vector domain domain domain list\n");
  const auto vector = [](const Eigen::Vector3d& v) {
    return Message("(", NumberText(v[0]), ",", NumberText(v[1]), ",", NumberText(v[2]), ")");
  };
  text += "space directions: none";
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    text += " " + vector(nodes.direction.col(axis) * nodes.spacing_mm[axis]);
  }
  text += " none\nspace origin: " + vector(nodes.origin_mm) +
          "\nendian: little\nencoding: raw\ndata file: fields.raw\n";
  return text;
}

void WriteFields(const std::filesystem::path& path, const MotionField& field) {
  std::ofstream out(path, std::ios::binary);
  for (int n = 0; n < field.num_components(); ++n) {
    for (int k = 0; k < field.nodes().size[2]; ++k) {
      for (int j = 0; j < field.nodes().size[1]; ++j) {
        const auto row = field.StoredRow(n, j, k);
        out.write(reinterpret_cast<const char*>(row.data()),
                  static_cast<std::streamsize>(row.size_bytes()));
      }
    }
  }
  out.close();
  ACUS_REQUIRE(out.good(), path.string(), ": cannot be written; is the disk full?");
}

void ReadFields(const std::filesystem::path& path, const std::vector<double>& mm_per_unit,
                MotionField& field) {
  const std::size_t values = 3 * field.nodes().num_voxels();
  RequireInputFile(path);
  std::ifstream in(path, std::ios::binary);
  std::vector<std::int16_t> stored(values);
  for (std::size_t n = 0; n < mm_per_unit.size(); ++n) {
    in.read(reinterpret_cast<char*>(stored.data()),
            static_cast<std::streamsize>(stored.size() * sizeof(std::int16_t)));
    ACUS_REQUIRE(in.good(), path.string(), ": cannot be read to its end");
    field.SetStored(static_cast<int>(n), stored, mm_per_unit[n]);
  }
}

/// Before anything is allocated for what the file says.
void RequireSize(const std::filesystem::path& path, const volume::Geometry& nodes,
                 std::size_t num_fields) {
  std::error_code error;
  const auto found = std::filesystem::file_size(path, error);
  ACUS_REQUIRE(!error, path.string(), ": cannot be read; it belongs beside motion.json");
  const std::size_t bytes = 3 * sizeof(std::int16_t) * nodes.num_voxels();
  ACUS_REQUIRE(found == num_fields * bytes, path.string(), ": ", found,
               " bytes, where motion.json speaks of ", num_fields, " fields of ", bytes,
               " bytes. Were the files copied whole, and from one folder?");
}

MotionModel ModelOf(const json& document, MotionField field) {
  std::vector<KeyFrame> frames;
  for (const json& frame : document.at("frames")) {
    frames.push_back({frame.at("at").get<double>(), frame.at("field").get<int>()});
  }
  const auto name = document.at("model").get<std::string>();
  if (name == NameOf(MotionKind::kFullCycle)) {
    return MotionModel::FullCycle(std::move(field), std::move(frames));
  }
  if (name == NameOf(MotionKind::kHalfCycle)) {
    return MotionModel::HalfCycle(std::move(field), std::move(frames));
  }
  if (name == NameOf(MotionKind::kSurrogate)) return MotionModel::Surrogate(std::move(field));
  return MotionModel::Sinusoid(std::move(field), document.at("reference_level").get<double>());
}

}  // namespace

Breath PatientMotion::InTermsOfSignal(const Breath& normal) const noexcept {
  const double span = inspiration_level - expiration_level;
  return {.cycle = normal.cycle,
          .level = expiration_level + span * normal.level,
          .level_per_s = span * normal.level_per_s};
}

Breath PatientMotion::Normal(const Breath& of_signal) const noexcept {
  const double span = inspiration_level - expiration_level;
  if (span == 0.0) return {.cycle = of_signal.cycle, .level = 1.0, .level_per_s = 0.0};
  return {.cycle = of_signal.cycle,
          .level = (of_signal.level - expiration_level) / span,
          .level_per_s = of_signal.level_per_s / span};
}

void WritePatientMotion(const std::filesystem::path& folder, const PatientMotion& motion) {
  const MotionModel& model = motion.model;
  const MotionField& field = model.field();
  json document = {{"format", "acus-motion/1"},
                   {"name", motion.name},
                   {"model", NameOf(model.kind())},
                   {"nodes", JsonOf(field.nodes())},
                   {"reference_level", model.reference_level()},
                   {"inspiration_level", motion.inspiration_level},
                   {"expiration_level", motion.expiration_level},
                   {"period_s", motion.period_s}};
  for (int n = 0; n < field.num_components(); ++n) {
    document["mm_per_unit"].push_back(field.MmPerUnit(n));
  }
  document["frames"] = json::array();
  for (const KeyFrame& frame : model.frames()) {
    document["frames"].push_back({{"at", frame.at}, {"field", frame.component}});
  }
  if (motion.bound) {
    document["bound"] = MotionBound::kFile;
    WriteMotionBound(folder, *motion.bound);
  }
  WriteFields(folder / "fields.raw", field);
  WriteTextFile(folder / "fields.nhdr", NrrdHeader(field));
  config::WriteJson(folder / "motion.json", document);
}

PatientMotion ReadPatientMotion(const std::filesystem::path& path) {
  const std::filesystem::path file =
      std::filesystem::is_directory(path) ? path / "motion.json" : path;
  const json document = config::ReadConfig(file, "acus-motion");
  const auto mm_per_unit = document.at("mm_per_unit").get<std::vector<double>>();
  const volume::Geometry nodes = NodesOf(document.at("nodes"), file);
  const auto fields = file.parent_path() / "fields.raw";
  RequireSize(fields, nodes, mm_per_unit.size());
  MotionField field(nodes, static_cast<int>(mm_per_unit.size()));
  ReadFields(fields, mm_per_unit, field);
  std::optional<MotionBound> bound;
  if (document.contains("bound")) {
    bound = ReadMotionBound(file.parent_path() / MotionBound::kFile, nodes);
  }
  try {
    return {.name = document.at("name").get<std::string>(),
            .model = ModelOf(document, std::move(field)),
            .inspiration_level = document.at("inspiration_level").get<double>(),
            .expiration_level = document.at("expiration_level").get<double>(),
            .period_s = document.at("period_s").get<double>(),
            .bound = std::move(bound)};
  } catch (const InputError& error) {
    throw InputError(file.string() + ": " + error.what());
  }
}

}  // namespace acus::breathing
