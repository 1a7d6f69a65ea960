// The structures of label maps made elsewhere, by name or code: configs/label_maps/names.json.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "acus/data/volume/value_names.h"
#include "acus/data/volume/volume.h"

namespace acus::segmentation {

enum class Side { kNone, kLeft, kRight };

/// One row of the table; configs/schema/acus-label-names.schema.json explains the values.
struct Structure {
  std::string name;
  volume::Label tissue = 0;
  double least_ml = 0.0;
  double most_ml = 0.0;
  bool is_paired = false;
  Side half = Side::kNone;
  bool is_midline = false;
  std::optional<double> height_mm = {};
  int order = 0;
};

struct NamedStructure {
  Structure structure;
  Side side = Side::kNone;  ///< Of this one of a pair.
};

struct HuRange {
  double least, most;
};

class LabelNames {
 public:
  /// @throws InputError if the file does not fit its schema, gives a name or a code twice, or names
  ///     a tissue that is not a standard label.
  explicit LabelNames(const std::filesystem::path& path);

  /// By the text, otherwise by the first code that is in the table, otherwise by the text with
  /// words divided at capitals and short sides ("Kidney_L"); nothing if none is.
  std::optional<NamedStructure> Find(const volume::ValueName& name) const;

  /// The name in the table that is nearest to one that is not in it, if it is near.
  std::optional<std::string> Nearest(const std::string& name) const;

  /// Whether a map that lists these names has a value in every voxel of the body.
  bool CoversBody(const volume::ValueNames& listed) const;
  /// Whether a map that lists these names contains every bone.
  bool HasAllBones(const volume::ValueNames& listed) const;

  /// HU that voxels of a tissue have; nothing if the table does not say.
  std::optional<HuRange> HuOf(volume::Label tissue) const;

 private:
  using Alternatives = std::vector<std::vector<std::string>>;
  bool ListsOneOf(const Alternatives& rows, const volume::ValueNames& listed) const;

  std::vector<Structure> structures_;
  std::map<std::string, std::size_t> by_key_;
  std::map<std::string, std::size_t> by_code_;
  std::vector<std::string> spellings_;
  std::map<volume::Label, HuRange> hu_;
  Alternatives covers_body_, all_bones_;
};

}  // namespace acus::segmentation
