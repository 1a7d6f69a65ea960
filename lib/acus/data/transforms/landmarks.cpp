#include "acus/data/transforms/landmarks.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <sstream>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/delimited_text.h"
#include "acus/base/core/error.h"
#include "acus/base/core/spelling.h"
#include "acus/base/core/words.h"
#include "acus/base/core/xml_scan.h"

namespace acus::transforms {
namespace {

using nlohmann::json;

constexpr double kFarthestMm = 1e6;  ///< Larger coordinates are a mistake of unit or a broken file.

/// Collects points one by one and checks each.
class Collector {
 public:
  explicit Collector(const std::filesystem::path& path) { landmarks_.source = path.string(); }

  void Add(const std::string& name, Eigen::Vector3d point_mm, bool is_ras,
           const std::string& where) {
    if (is_ras) point_mm.head<2>() *= -1.0;
    ACUS_REQUIRE(point_mm.allFinite() && point_mm.cwiseAbs().maxCoeff() <= kFarthestMm, where,
                 ": point '", name, "' is at (", point_mm.transpose(),
                 "); finite coordinates in mm, at most ", kFarthestMm, ", are needed");
    ACUS_REQUIRE(name.empty() || seen_.insert(name).second, where, ": the name '", name,
                 "' appears twice; rename one of the two points");
    landmarks_.names.push_back(name);
    points_.push_back(point_mm);
  }

  Landmarks Take() {
    ACUS_REQUIRE(!points_.empty(), landmarks_.source, ": holds no point");
    const bool none = seen_.empty();
    const bool all = seen_.size() == points_.size();
    ACUS_REQUIRE(none || all, landmarks_.source,
                 ": some points have a name and some have none; name all of them or none");
    landmarks_.points_mm.resize(3, static_cast<Eigen::Index>(points_.size()));
    for (std::size_t i = 0; i < points_.size(); ++i) {
      landmarks_.points_mm.col(static_cast<Eigen::Index>(i)) = points_[i];
    }
    return std::move(landmarks_);
  }

 private:
  Landmarks landmarks_;
  std::vector<Eigen::Vector3d> points_;
  std::set<std::string> seen_;
};

/// The localisation error of each point, if the table has it: see ReadLandmarks.
Markers DeviationsFrom(const CsvTable& table) {
  const auto count = static_cast<Eigen::Index>(table.num_rows());
  Markers sd_mm(3, 0);
  const std::array<const char*, 3> columns = {"sd_x_mm", "sd_y_mm", "sd_z_mm"};
  if (table.Has("fle_mm")) {
    const std::vector<double> fle_mm = table.Numbers("fle_mm");
    sd_mm.resize(3, count);
    for (Eigen::Index i = 0; i < count; ++i) {
      sd_mm.col(i).setConstant(fle_mm[static_cast<std::size_t>(i)] / std::sqrt(3.0));
    }
  } else if (table.Has(columns[0]) || table.Has(columns[1]) || table.Has(columns[2])) {
    sd_mm.resize(3, count);
    for (int axis = 0; axis < 3; ++axis) {
      const std::vector<double> values = table.Numbers(columns[static_cast<std::size_t>(axis)]);
      for (Eigen::Index i = 0; i < count; ++i) {
        sd_mm(axis, i) = values[static_cast<std::size_t>(i)];
      }
    }
  }
  for (Eigen::Index i = 0; i < sd_mm.cols(); ++i) {
    const double least = sd_mm.col(i).minCoeff();
    const double most = sd_mm.col(i).maxCoeff();
    ACUS_REQUIRE(least > 0.0 && most <= 1000.0, table.Where(static_cast<std::size_t>(i)),
                 ": the localisation error must be above 0 mm and at most 1000 mm, got ",
                 least > 0.0 ? most : least);
  }
  return sd_mm;
}

Landmarks FromTable(const CsvTable& table, const std::string& name_column,
                    const std::array<const char*, 3>& columns, bool is_ras) {
  const auto x = table.Numbers(columns[0]);
  const auto y = table.Numbers(columns[1]);
  const auto z = table.Numbers(columns[2]);
  std::vector<std::string> names(table.num_rows());
  if (table.Has(name_column)) names = table.Texts(name_column);
  Collector collector(table.path());
  for (std::size_t i = 0; i < table.num_rows(); ++i) {
    collector.Add(names[i], {x[i], y[i], z[i]}, is_ras, table.Where(i));
  }
  Landmarks landmarks = collector.Take();
  landmarks.sd_mm = DeviationsFrom(table);
  landmarks.how_read = table.how_read();
  for (const char* column : columns) {
    const std::string taken = table.Taken(column);
    if (!taken.empty()) landmarks.how_read += (landmarks.how_read.empty() ? "" : "; ") + taken;
  }
  return landmarks;
}

Landmarks ReadCsv(const std::filesystem::path& path) {
  const CsvTable table(path);
  if (table.Has("l") && table.Has("p") && table.Has("s")) {
    return FromTable(table, "label", {"l", "p", "s"}, /*is_ras=*/false);
  }
  if (table.Has("r") && table.Has("a") && table.Has("s")) {
    return FromTable(table, "label", {"r", "a", "s"}, /*is_ras=*/true);
  }
  return FromTable(table, "name", {"x_mm", "y_mm", "z_mm"}, /*is_ras=*/false);
}

/// Whether a Slicer file's coordinateSystem means RAS.
bool IsRas(const std::string& text, const std::string& where) {
  if (text == "RAS" || text == "0") return true;
  ACUS_REQUIRE(text == "LPS" || text == "1", where, ": is \"", text,
               "\"; LPS (or 1) and RAS (or 0) are known");
  return false;
}

Landmarks ReadFcsv(const std::filesystem::path& path) {
  std::istringstream lines(Utf8Text(ReadTextFile(path), path.string()));
  bool is_ras = true;  // Files older than the key are RAS.
  bool has_system = false;
  for (std::string line; std::getline(lines, line) && line.starts_with('#');) {
    const auto equals = line.find('=');
    ACUS_REQUIRE(
        line.find("columns") == line.npos || equals == line.npos ||
            line.find("id,x,y,z,") != line.npos || line.find("label,desc") != line.npos,
        path.string(), ": has the columns '", Trimmed(line.substr(equals + 1)),
        "'; those of 3D Slicer 4.2 and later (id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,...) "
        "are read. Open the points in 3D Slicer and save them again");
    if (line.find("CoordinateSystem") == line.npos || equals == line.npos) continue;
    std::string value = line.substr(equals + 1);
    std::erase_if(value, [](unsigned char c) { return std::isspace(c) != 0; });
    is_ras = IsRas(value, path.string() + ": CoordinateSystem");
    has_system = true;
  }
  const CsvTable table(path, {"id", "x", "y", "z", "ow", "ox", "oy", "oz", "vis", "sel", "lock",
                              "label", "desc", "associatedNodeID"});
  Landmarks landmarks = FromTable(table, "label", {"x", "y", "z"}, is_ras);
  if (!has_system) {
    landmarks.how_read += Message(landmarks.how_read.empty() ? "" : "; ",
                                  "no CoordinateSystem in it: taken as RAS, as in old files");
  }
  return landmarks;
}

/// The member `key` of `node`, or null.
const json& Member(const json& node, const char* key) {
  static const json kNull;
  return node.is_object() && node.contains(key) ? node.at(key) : kNull;
}

std::string TextOf(const json& node) {
  return node.is_string() ? node.get<std::string>() : node.dump();
}

/// mm per unit of a point list: a word, three words, or a code of three words ("mm", "UCUM",
/// "millimeter").
double MillimetresPerUnit(const json& units, const std::string& where) {
  if (units.is_null()) return 1.0;
  const json& first = units.is_array() && !units.empty() ? units[0] : units;
  const auto factor = first.is_string()
                          ? UnitFactor(ParseColumnName(first.get<std::string>()).words, "mm")
                          : std::nullopt;
  ACUS_REQUIRE(factor, where, "/coordinateUnits: is ", TextOf(units).substr(0, 60),
               "; units of length (mm, cm, m, um) are read");
  return *factor;
}

void AddControlPoint(const json& point, bool is_ras, double mm_per_unit, const std::string& where,
                     Collector& collector) {
  const json& status = Member(point, "positionStatus");
  if (status.is_string() && status != "defined") return;  // Not placed yet.
  const json& position = Member(point, "position");
  const auto is_number = [](const json& value) { return value.is_number(); };
  ACUS_REQUIRE(
      position.is_array() && position.size() == 3 && std::ranges::all_of(position, is_number),
      where, "/position: must be three numbers, got ", TextOf(position).substr(0, 60));
  const json& label = Member(point, "label");
  const std::string name = label.is_string() ? label.get<std::string>() : "";
  collector.Add(name,
                mm_per_unit * Eigen::Vector3d(position[0].get<double>(), position[1].get<double>(),
                                              position[2].get<double>()),
                is_ras, where);
}

Landmarks ReadMarkupsJson(const std::filesystem::path& path) {
  const json document = config::ReadJson(path);
  const json& markups = Member(document, "markups");
  ACUS_REQUIRE(markups.is_array() && !markups.empty(), path.string(),
               ": /markups: must be a list of point lists; is this a Slicer markups file?");
  Collector collector(path);
  for (std::size_t m = 0; m < markups.size(); ++m) {
    const std::string where = Message(path.string(), ": /markups/", m);
    const json& system = Member(markups[m], "coordinateSystem");
    const bool is_ras = !system.is_null() && IsRas(TextOf(system), where + "/coordinateSystem");
    const double mm_per_unit = MillimetresPerUnit(Member(markups[m], "coordinateUnits"), where);
    const json& points = Member(markups[m], "controlPoints");
    ACUS_REQUIRE(points.is_array(), where, "/controlPoints: must be a list");
    for (std::size_t i = 0; i < points.size(); ++i) {
      AddControlPoint(points[i], is_ras, mm_per_unit, Message(where, "/controlPoints/", i),
                      collector);
    }
  }
  Landmarks landmarks = collector.Take();
  if (Member(markups[0], "coordinateSystem").is_null()) {
    landmarks.how_read = "no coordinateSystem in it: taken as LPS";
  }
  return landmarks;
}

/// The landmarks of a phantom definition in a PLUS configuration.
Landmarks ReadPlusPhantom(const std::filesystem::path& path) {
  Collector collector(path);
  for (const auto& element : core::ScanXml(ReadTextFile(path), path.string())) {
    if (element.name != "Landmark") continue;
    const std::string name = element.Attribute("Name").value_or("");
    std::istringstream position(element.Attribute("Position").value_or(""));
    Eigen::Vector3d point_mm;
    std::string rest;
    const bool complete =
        static_cast<bool>(position >> point_mm[0] >> point_mm[1] >> point_mm[2]) &&
        !(position >> rest);
    ACUS_REQUIRE(complete, path.string(), ": landmark '", name,
                 "': Position must be three numbers, got \"",
                 element.Attribute("Position").value_or(""), "\"");
    collector.Add(name, point_mm, /*is_ras=*/false, path.string());
  }
  return collector.Take();
}

void WriteCsv(const std::filesystem::path& path, const Landmarks& landmarks) {
  std::string text = "name,x_mm,y_mm,z_mm\n";
  for (Eigen::Index i = 0; i < landmarks.points_mm.cols(); ++i) {
    const std::string& name = landmarks.names[static_cast<std::size_t>(i)];
    const bool plain =
        name.find_first_of(",\n\r#") == name.npos && !name.starts_with(' ') && !name.ends_with(' ');
    ACUS_REQUIRE(plain, path.string(), ": the name '", name,
                 "' cannot stand in a CSV file; omit commas, '#', line ends and outer spaces");
    const Eigen::Vector3d point = landmarks.points_mm.col(i);
    text += name + "," + NumberText(point.x()) + "," + NumberText(point.y()) + "," +
            NumberText(point.z()) + "\n";
  }
  WriteTextFile(path, text);
}

void WriteMarkupsJson(const std::filesystem::path& path, const Landmarks& landmarks) {
  json points = json::array();
  for (Eigen::Index i = 0; i < landmarks.points_mm.cols(); ++i) {
    const Eigen::Vector3d point = landmarks.points_mm.col(i);
    points.push_back({{"id", std::to_string(i + 1)},
                      {"label", landmarks.names[static_cast<std::size_t>(i)]},
                      {"position", {point.x(), point.y(), point.z()}},
                      {"positionStatus", "defined"}});
  }
  config::WriteJson(path, {{"markups",
                            {{{"type", "Fiducial"},
                              {"coordinateSystem", "LPS"},
                              {"coordinateUnits", "mm"},
                              {"controlPoints", points}}}}});
}

std::string Joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "'" : ", '") + word + "'";
  return text;
}

/// The columns of the first or second members; nothing of nothing.
Markers Chosen(const Markers& all,
               const std::vector<std::pair<Eigen::Index, Eigen::Index>>& matches, bool second) {
  if (all.cols() == 0) return Markers(3, 0);
  Markers chosen(3, static_cast<Eigen::Index>(matches.size()));
  for (std::size_t k = 0; k < matches.size(); ++k) {
    chosen.col(static_cast<Eigen::Index>(k)) =
        all.col(second ? matches[k].second : matches[k].first);
  }
  return chosen;
}

/// How tables in another form than the plain one were read.
void SayHowRead(const Landmarks& reference, const Landmarks& ct, MarkerPairs& pairs) {
  for (const Landmarks* landmarks : {&reference, &ct}) {
    if (landmarks->how_read.empty()) continue;
    pairs.warnings.push_back(Message(landmarks->source, ": ", landmarks->how_read));
  }
}

Landmarks WithLowerNames(Landmarks landmarks) {
  for (std::string& name : landmarks.names) {
    std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
  }
  return landmarks;
}

bool ShareAName(const Landmarks& a, const Landmarks& b) {
  return std::ranges::any_of(a.names, [&](const std::string& name) {
    return !name.empty() && std::ranges::find(b.names, name) != b.names.end();
  });
}

MarkerPairs MatchByOrder(const Landmarks& reference, const Landmarks& ct) {
  ACUS_REQUIRE(reference.points_mm.cols() == ct.points_mm.cols(), reference.source, " has ",
               reference.points_mm.cols(), " points, ", ct.source, " has ", ct.points_mm.cols(),
               ", and they have no name in common; give the same point the same name in both");
  MarkerPairs pairs{reference.names, reference.points_mm, ct.points_mm, {}, reference.sd_mm,
                    ct.sd_mm};
  for (std::size_t i = 0; i < pairs.names.size(); ++i) {
    if (pairs.names[i].empty()) pairs.names[i] = Message("#", i + 1);
  }
  pairs.warnings.push_back(Message(reference.source, " and ", ct.source,
                                   " have no name in common: points are matched by their order"));
  SayHowRead(reference, ct, pairs);
  return pairs;
}

}  // namespace

Landmarks ReadLandmarks(const std::filesystem::path& path) {
  const std::string name = path.filename().string();
  if (name.ends_with(".json")) return ReadMarkupsJson(path);
  if (name.ends_with(".fcsv")) return ReadFcsv(path);
  if (name.ends_with(".xml")) return ReadPlusPhantom(path);
  const bool is_table = name.ends_with(".csv") || name.ends_with(".tsv") || name.ends_with(".txt");
  ACUS_REQUIRE(is_table, path.string(),
               ": is of an unknown kind; landmarks are read from tables (.csv, .tsv, .txt), "
               ".mrk.json, .fcsv and .xml");
  return ReadCsv(path);
}

void WriteLandmarks(const std::filesystem::path& path, const Landmarks& landmarks) {
  ACUS_ASSERT(static_cast<Eigen::Index>(landmarks.names.size()) == landmarks.points_mm.cols());
  const std::string name = path.filename().string();
  if (name.ends_with(".csv")) return WriteCsv(path, landmarks);
  ACUS_REQUIRE(name.ends_with(".mrk.json"), path.string(),
               ": landmarks are written as .csv or .mrk.json");
  WriteMarkupsJson(path, landmarks);
}

MarkerPairs MatchLandmarks(const Landmarks& reference, const Landmarks& ct, std::size_t least) {
  std::vector<std::pair<Eigen::Index, Eigen::Index>> matches;
  std::vector<std::string> lonely;
  const Landmarks lower_ct = WithLowerNames(ct), lower_reference = WithLowerNames(reference);
  if (!ShareAName(reference, ct) && ShareAName(lower_reference, lower_ct)) {
    return MatchLandmarks(lower_reference, lower_ct, least);
  }
  for (std::size_t i = 0; i < reference.names.size(); ++i) {
    const auto found = std::ranges::find(ct.names, reference.names[i]);
    if (reference.names[i].empty() || found == ct.names.end()) {
      lonely.push_back(reference.names[i]);
    } else {
      matches.emplace_back(i, found - ct.names.begin());
    }
  }
  if (matches.empty()) return MatchByOrder(reference, ct);
  MarkerPairs pairs;
  pairs.reference_mm.resize(3, static_cast<Eigen::Index>(matches.size()));
  pairs.ct_mm.resize(3, static_cast<Eigen::Index>(matches.size()));
  for (std::size_t k = 0; k < matches.size(); ++k) {
    const auto [i, j] = matches[k];
    pairs.names.push_back(reference.names[static_cast<std::size_t>(i)]);
    pairs.reference_mm.col(static_cast<Eigen::Index>(k)) = reference.points_mm.col(i);
    pairs.ct_mm.col(static_cast<Eigen::Index>(k)) = ct.points_mm.col(j);
  }
  pairs.reference_sd_mm = Chosen(reference.sd_mm, matches, /*second=*/false);
  pairs.ct_sd_mm = Chosen(ct.sd_mm, matches, /*second=*/true);
  const auto warn = [&pairs](const std::vector<std::string>& names, const std::string& has,
                             const std::string& has_not) {
    if (names.empty()) return;
    pairs.warnings.push_back(Message(has_not, " lacks ", Joined(names), " of ", has,
                                     ": excluded from the registration"));
  };
  warn(lonely, reference.source, ct.source);
  lonely.clear();
  for (const std::string& name : ct.names) {
    if (std::ranges::find(pairs.names, name) == pairs.names.end()) lonely.push_back(name);
  }
  warn(lonely, ct.source, reference.source);
  ACUS_REQUIRE(matches.size() >= least, reference.source, " and ", ct.source, " have only ",
               matches.size(), " names in common (", Joined(pairs.names), "); at least ", least,
               " points are needed");
  SayHowRead(reference, ct, pairs);
  return pairs;
}

MarkerPairs Without(const MarkerPairs& pairs, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    ACUS_REQUIRE(std::ranges::find(pairs.names, name) != pairs.names.end(), "no point is named '",
                 name, "'; the matched points are ", Joined(pairs.names));
  }
  MarkerPairs rest;
  rest.warnings = pairs.warnings;
  std::vector<Eigen::Index> kept;
  for (std::size_t i = 0; i < pairs.names.size(); ++i) {
    if (std::ranges::find(names, pairs.names[i]) != names.end()) continue;
    kept.push_back(static_cast<Eigen::Index>(i));
    rest.names.push_back(pairs.names[i]);
  }
  rest.reference_mm = pairs.reference_mm(Eigen::all, kept);
  rest.ct_mm = pairs.ct_mm(Eigen::all, kept);
  if (pairs.reference_sd_mm.cols() > 0) {
    rest.reference_sd_mm = pairs.reference_sd_mm(Eigen::all, kept);
  }
  if (pairs.ct_sd_mm.cols() > 0) rest.ct_sd_mm = pairs.ct_sd_mm(Eigen::all, kept);
  return rest;
}

}  // namespace acus::transforms
