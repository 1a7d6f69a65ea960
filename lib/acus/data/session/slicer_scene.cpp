#include "acus/data/session/slicer_scene.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <functional>
#include <memory>
#include <optional>
#include <set>

#include "acus/base/core/error.h"
#include "acus/base/core/input_file.h"
#include "acus/base/core/xml_scan.h"
#include "acus/data/session/pose_csv.h"
#include "acus/data/session/sequence_header.h"
#include "acus/data/session/zip_archive.h"
#include "acus/data/transforms/itk_transform_file.h"

namespace acus::session {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMaxSceneBytes = std::uint64_t{1} << 28U;
constexpr std::uint64_t kMaxTransformBytes = std::uint64_t{1} << 20U;
constexpr std::uint64_t kMaxBundleBytes = std::uint64_t{1} << 31U;
constexpr std::string_view kSequenceEnding = "-Sequence";

using Bytes = std::vector<std::uint8_t>;

/// Where a scene's files come from: its folder, or the archive around it.
struct SceneFiles {
  std::string label;  ///< Of the scene, for messages.
  std::string text;   ///< The scene itself.
  std::function<Bytes(const std::string& name, std::uint64_t max_bytes)> read;
};

Bytes ReadBytes(const fs::path& path, std::uint64_t max_bytes) {
  const auto size = RequireInputFile(path, max_bytes);
  Bytes bytes(size);
  std::ifstream file(path, std::ios::binary);
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  ACUS_REQUIRE(file, path.string(), ": cannot be read");
  return bytes;
}

/// Scenes write names of files as in a URL: "My%20Needle.h5". They must lie beside the scene.
std::string FileName(const std::string& encoded, const std::string& label) {
  std::string name;
  for (std::size_t i = 0; i < encoded.size(); ++i) {
    const bool is_code = encoded[i] == '%' && i + 2 < encoded.size() &&
                         std::isxdigit(static_cast<unsigned char>(encoded[i + 1])) != 0 &&
                         std::isxdigit(static_cast<unsigned char>(encoded[i + 2])) != 0;
    name +=
        is_code ? static_cast<char>(std::stoi(encoded.substr(i + 1, 2), nullptr, 16)) : encoded[i];
    if (is_code) i += 2;
  }
  const fs::path path = fs::path(name).lexically_normal();
  ACUS_REQUIRE(
      !path.empty() && path.is_relative() && *path.begin() != ".." && name.find('\0') == name.npos,
      label, ": its file '", name, "' does not lie beside it");
  return path.generic_string();
}

SceneFiles FilesOfFolder(const fs::path& scene) {
  const Bytes text = ReadBytes(scene, kMaxSceneBytes);
  return {scene.string(), std::string(text.begin(), text.end()),
          [folder = scene.parent_path()](const std::string& name, std::uint64_t max_bytes) {
            return ReadBytes(folder / name, max_bytes);
          }};
}

SceneFiles FilesOfArchive(ZipArchive opened, const std::string& label) {
  const auto archive = std::make_shared<ZipArchive>(std::move(opened));
  const auto& names = archive->names();
  const auto is_scene = [](const std::string& name) { return name.ends_with(".mrml"); };
  const auto found = std::ranges::find_if(names, is_scene);
  ACUS_REQUIRE(found != names.end() && std::ranges::count_if(names, is_scene) == 1, label,
               ": must hold one scene (.mrml), as Slicer's bundles do");
  const std::string folder = found->substr(0, found->find_last_of('/') + 1);
  const Bytes text = archive->Read(*found, kMaxSceneBytes);
  return {label + "/" + *found, std::string(text.begin(), text.end()),
          [archive, folder](const std::string& name, std::uint64_t max_bytes) {
            return archive->Read(folder + name, max_bytes);
          }};
}

/// Reads the transforms of one scene; sequences are scenes of their own in a bundle.
class SceneReader {
 public:
  explicit SceneReader(SceneFiles files)
      : files_(std::move(files)), elements_(core::ScanXml(files_.text, files_.label)) {
    ACUS_REQUIRE(elements_.front().name == "MRML", files_.label, ": is not a Slicer scene (MRML)");
    // Depth 1 only: a SceneView holds copies of nodes, with the same ids, at a greater depth.
    for (const core::XmlElement& element : elements_) {
      const auto id = element.Attribute("id");
      if (element.depth == 1 && id) nodes_[*id] = &element;
    }
  }

  SceneReader(const SceneReader&) = delete;  // nodes_ points into elements_.
  SceneReader& operator=(const SceneReader&) = delete;

  const std::vector<core::XmlElement>& elements() const { return elements_; }
  const std::string& label() const { return files_.label; }

  const core::XmlElement* Node(const std::string& id) const {
    const auto found = nodes_.find(id);
    return found == nodes_.end() ? nullptr : found->second;
  }

  /// The transforms to parent in RAS: from their files (exact), or else from the scene (six
  /// digits). Only nodes that are linear transforms have one.
  std::vector<std::optional<Eigen::Matrix4d>> Matrices(
      const std::vector<const core::XmlElement*>& nodes) const {
    std::vector<std::optional<Eigen::Matrix4d>> matrices;
    std::vector<std::size_t> places;
    std::vector<transforms::ItkTransformSource> files;
    for (const core::XmlElement* node : nodes) {
      const auto file = StorageFile(*node);
      const bool has_file = file && file->ends_with(".h5");
      if (has_file) {
        places.push_back(matrices.size());
        files.push_back({files_.label + ": " + *file,
                         [this, name = *file] { return files_.read(name, kMaxTransformBytes); }});
      }
      matrices.push_back(has_file ? std::nullopt : MatrixInScene(*node));
    }
    const auto read = transforms::ReadItkAffines(files);
    for (std::size_t i = 0; i < read.size(); ++i) {
      matrices[places[i]] = transforms::RasToParentFromItk(read[i], files[i].label);
    }
    return matrices;
  }

  /// The scene of the sequence's own bundle.
  SceneFiles Bundle(const core::XmlElement& sequence) const {
    const auto file = StorageFile(sequence);
    const std::string name = sequence.Attribute("name").value_or("?");
    ACUS_REQUIRE(file && file->ends_with(".mrb"), files_.label, ": the sequence ", name,
                 " is not stored as .mrb; in Slicer, save it as a bundle (.mrb)");
    const std::string label = files_.label + ": " + *file;
    return FilesOfArchive(ZipArchive(files_.read(*file, kMaxBundleBytes), label), label);
  }

 private:
  std::optional<Eigen::Matrix4d> MatrixInScene(const core::XmlElement& transform) const {
    const auto text = transform.Attribute("matrixTransformToParent");
    if (!text) return {};
    const auto numbers = NumbersOf(*text);
    ACUS_REQUIRE(numbers && numbers->size() == 16, files_.label, ": matrixTransformToParent of ",
                 transform.Attribute("name").value_or("?"), " is not 16 finite numbers");
    return Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers->data());
  }

  std::optional<std::string> StorageFile(const core::XmlElement& node) const {
    const auto id = node.Attribute("storageNodeRef");
    const core::XmlElement* storage = id ? Node(*id) : nullptr;
    const auto file = storage == nullptr ? std::nullopt : storage->Attribute("fileName");
    if (!file || file->empty()) return {};
    return FileName(*file, files_.label);
  }

  SceneFiles files_;
  std::vector<core::XmlElement> elements_;
  std::map<std::string, const core::XmlElement*> nodes_;
};

/// indexValues="node1:0.068;node2:0.245;...": which node was recorded when.
std::vector<TimedMatrix> ReadSequence(const core::XmlElement& sequence, const SceneReader& scene,
                                      const SceneReader& bundle) {
  std::vector<std::int64_t> times_ns;
  std::vector<const core::XmlElement*> nodes;
  const std::string name = sequence.Attribute("name").value_or("?");
  const std::string unit = sequence.Attribute("indexUnit").value_or("s");
  ACUS_REQUIRE(unit == "s", scene.label(), ": the sequence ", name, " counts in '", unit,
               "'; only seconds (s) are read");
  const std::string values = sequence.Attribute("indexValues").value_or("");
  for (std::size_t begin = 0; begin < values.size();) {
    const std::size_t end = std::min(values.find(';', begin), values.size());
    const std::string entry = values.substr(begin, end - begin);
    begin = end + 1;
    const std::size_t colon = entry.find(':');
    const auto time_ns =
        colon == entry.npos ? std::nullopt : NanosecondsFromText(entry.substr(colon + 1));
    ACUS_REQUIRE(time_ns, scene.label(), ": the sequence ", name, " has the index value '", entry,
                 "'; node:seconds is needed");
    const core::XmlElement* node = bundle.Node(entry.substr(0, colon));
    ACUS_REQUIRE(node != nullptr, bundle.label(), ": has no node ", entry.substr(0, colon),
                 ", which the sequence ", name, " names");
    times_ns.push_back(*time_ns);
    nodes.push_back(node);
  }
  std::vector<TimedMatrix> entries;
  const auto matrices = bundle.Matrices(nodes);
  for (std::size_t i = 0; i < matrices.size(); ++i) {
    if (!matrices[i]) return {};  // Not a sequence of linear transforms.
    entries.push_back({times_ns[i], *matrices[i]});
  }
  // The list follows the order of recording, but nothing in the format says so.
  std::ranges::stable_sort(entries, {}, &TimedMatrix::time_ns);
  return entries;
}

/// "NeedleToReference" from the name of its sequence node.
std::string RecordedName(const core::XmlElement& sequence) {
  std::string name = sequence.Attribute("name").value_or("");
  if (name.ends_with(kSequenceEnding)) name.resize(name.size() - kSequenceEnding.size());
  return name;
}

/// All entries at one time, the last one known at or before it for each sequence.
transforms::TransformGraph GraphAt(const SlicerScene& scene, const std::vector<std::string>& names,
                                   std::int64_t time_ns) {
  transforms::TransformGraph graph;
  for (const std::string& name : names) {
    const auto& entries = scene.sequences.at(name);
    auto after = std::ranges::upper_bound(entries, time_ns, {}, &TimedMatrix::time_ns);
    if (after == entries.begin()) continue;
    graph.Set(*transforms::ParseTransformName(name), (after - 1)->to_from_from, true);
  }
  graph.AddMissing(scene.fixed);
  return graph;
}

}  // namespace

SlicerScene ReadSlicerScene(const fs::path& path) {
  const SceneReader reader(path.extension() == ".mrb"
                               ? FilesOfArchive(ZipArchive(path), path.string())
                               : FilesOfFolder(path));
  SlicerScene scene;
  for (const core::XmlElement& element : reader.elements()) {
    if (element.depth != 1 || element.name != "Sequence") continue;
    const std::string name = RecordedName(element);
    if (!transforms::ParseTransformName(name) ||
        element.Attribute("indexValues").value_or("").empty())
      continue;
    auto entries = ReadSequence(element, reader, SceneReader(reader.Bundle(element)));
    if (!entries.empty()) scene.sequences[name] = std::move(entries);
  }
  for (const core::XmlElement& element : reader.elements()) {
    if (element.depth != 1 || element.name != "LinearTransform") continue;
    const std::string name = element.Attribute("name").value_or("");
    const auto frames = transforms::ParseTransformName(name);
    // Slicer shows a recorded transform through a node of the same name: its present value.
    if (!frames || scene.sequences.contains(name)) continue;
    if (const auto matrix = reader.Matrices({&element}).front())
      scene.fixed.Set(*frames, *matrix, true);
  }
  ACUS_REQUIRE(!scene.sequences.empty(), path.string(),
               ": has no recorded transforms with time stamps. Give the scene (.mrml) that the "
               "sequences belong to: the time stamps are in it");
  return scene;
}

std::vector<TimedTransforms> InstantsFor(const SlicerScene& scene, const std::string& frame,
                                         const std::string& reference) {
  std::vector<std::string> used;
  for (const auto& [name, entries] : scene.sequences) {
    const auto graph = GraphAt(scene, {name}, entries.front().time_ns);
    if (graph.Find(frame, reference)) used = {name};
  }
  if (used.empty()) {
    for (const auto& [name, entries] : scene.sequences) used.push_back(name);
  }
  std::set<std::int64_t> times;
  for (const std::string& name : used) {
    for (const TimedMatrix& entry : scene.sequences.at(name)) times.insert(entry.time_ns);
  }
  std::vector<TimedTransforms> instants;
  instants.reserve(times.size());
  for (const std::int64_t time_ns : times) {
    instants.push_back({time_ns, GraphAt(scene, used, time_ns)});
  }
  return instants;
}

std::string TransformNames(const SlicerScene& scene) {
  std::string names = scene.fixed.Names();
  for (const auto& [name, entries] : scene.sequences) names += ", " + name;
  return names;
}

}  // namespace acus::session
