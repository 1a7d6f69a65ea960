#include "acus/data/transforms/transform_file.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/delimited_text.h"
#include "acus/base/core/error.h"
#include "acus/base/core/number_text.h"
#include "acus/base/core/words.h"
#include "acus/base/math/rigid.h"
#include "acus/data/transforms/itk_transform_file.h"

namespace acus::transforms {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Vector3d;

constexpr double kFarthestTranslationMm = 1e6;
constexpr std::string_view kComposite = "CompositeTransform_";
constexpr std::size_t kMostParts = 100;
constexpr std::string_view kMagic = "#Insight Transform File V1.0";

/// The text without the lines that are comments.
std::string WithoutComments(std::string_view text) {
  std::string rest;
  for (const std::string& line : LinesOf(text)) {
    if (!IsCommentLine(line)) rest += line + "\n";
  }
  return rest;
}

/// All numbers of a text; nothing else may be in it.
std::vector<double> Numbers(std::string_view text, const std::string& where) {
  constexpr std::string_view kSeparators = " \t\r\n,";
  std::vector<double> numbers;
  for (std::size_t begin = text.find_first_not_of(kSeparators); begin != text.npos;) {
    const std::size_t end = std::min(text.find_first_of(kSeparators, begin), text.size());
    const std::string_view word = text.substr(begin, end - begin);
    const auto value = ParseFinite(word);
    ACUS_REQUIRE(value, where, ": '", word.substr(0, 40), "' is not a finite number");
    numbers.push_back(*value);
    begin = text.find_first_not_of(kSeparators, end);
  }
  return numbers;
}

Eigen::Isometry3d RigidWithin(const Matrix4d& matrix, const std::string& label) {
  ACUS_REQUIRE(math::IsRigid(matrix), label,
               ": is not a rigid transform (rotation and translation); got the matrix ",
               matrix.row(0), "; ", matrix.row(1), "; ", matrix.row(2));
  const double farthest_mm = matrix.topRightCorner<3, 1>().cwiseAbs().maxCoeff();
  ACUS_REQUIRE(farthest_mm <= kFarthestTranslationMm, label,
               ": the translation is more than a kilometre; is the unit mm?");
  // A file with all its digits keeps them; a rounded one is made rigid again.
  return math::IsRigid(matrix, 1e-14) ? Eigen::Isometry3d(matrix) : math::RigidFromMatrix(matrix);
}

/// The transforms of a text file: one, or a composite transform and its parts.
std::vector<ItkTransform> TextTransforms(std::string_view text, const std::string& file) {
  std::vector<ItkTransform> blocks;
  std::vector<std::pair<bool, bool>> has_numbers;  // Parameters, fixed parameters.
  int line_number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string_view line = Trimmed(text.substr(begin, end - begin));
    begin = end + 1;
    ++line_number;
    if (line.empty() || line.front() == '#') continue;
    const std::string where = Message(file, ":", line_number);
    const auto colon = line.find(':');
    ACUS_REQUIRE(colon != line.npos, where, ": 'key: value' is needed, got '", line.substr(0, 40),
                 "'");
    const std::string_view key = Trimmed(line.substr(0, colon));
    const std::string_view value = Trimmed(line.substr(colon + 1));
    if (key == "Transform") {
      ACUS_REQUIRE(blocks.empty() || blocks.front().type.starts_with(kComposite), where,
                   ": a second transform; save the one that is meant (in Slicer: harden it first)");
      ACUS_REQUIRE(blocks.size() < kMostParts, where, ": more than ", kMostParts, " transforms");
      blocks.emplace_back().type = value;
      has_numbers.emplace_back();
    } else if (!blocks.empty() && key == "Parameters") {
      blocks.back().parameters = Numbers(value, where);
      has_numbers.back().first = true;
    } else if (!blocks.empty() && key == "FixedParameters") {
      blocks.back().fixed = Numbers(value, where);
      has_numbers.back().second = true;
    } else {
      throw InputError(Message(where, ": unknown key '", key.substr(0, 40),
                               "'; Transform, Parameters and FixedParameters are known"));
    }
  }
  for (std::size_t n = 0; n < blocks.size(); ++n) {
    const bool is_composite = n == 0 && blocks[n].type.starts_with(kComposite);
    ACUS_REQUIRE(is_composite || (has_numbers[n].first && has_numbers[n].second), file,
                 ": has no complete transform; each needs the lines Transform, Parameters and "
                 "FixedParameters");
  }
  return blocks;
}

/// The rotation of a versor given by its vector part. @throws InputError if that is too long.
Matrix3d FromVersor(const Vector3d& vector, const std::string& file) {
  const double squared = vector.squaredNorm();
  ACUS_REQUIRE(squared <= 1.0 + 1e-9, file, ": the versor's vector part is longer than 1");
  const double w = std::sqrt(std::max(0.0, 1.0 - squared));
  return Eigen::Quaterniond(w, vector.x(), vector.y(), vector.z()).normalized().toRotationMatrix();
}

Matrix3d FromEuler(const Vector3d& angles_rad, bool zyx) {
  const AngleAxisd x(angles_rad.x(), Vector3d::UnitX());
  const AngleAxisd y(angles_rad.y(), Vector3d::UnitY());
  const AngleAxisd z(angles_rad.z(), Vector3d::UnitZ());
  return zyx ? (z * y * x).toRotationMatrix() : (z * x * y).toRotationMatrix();
}

/// Matrix and translation about the centre. ITK: x' = matrix (x - centre) + centre + translation.
struct Parts {
  Matrix3d matrix = Matrix3d::Identity();
  Vector3d translation = Vector3d::Zero();
};

Parts PartsOf(const ItkTransform& block, const std::string& file) {
  const std::vector<double>& p = block.parameters;
  const auto require_count = [&](std::size_t count) {
    ACUS_REQUIRE(p.size() == count, file, ": ", block.type, " needs ", count, " parameters, got ",
                 p.size());
  };
  const auto vector_at = [&p](std::size_t i) { return Vector3d(p[i], p[i + 1], p[i + 2]); };
  const auto is = [&block](std::string_view kind) { return block.type.starts_with(kind); };
  Parts parts;
  if (is("AffineTransform_") || is("MatrixOffsetTransformBase_")) {
    require_count(12);
    parts.matrix = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(p.data());
    parts.translation = vector_at(9);
  } else if (is("Euler3DTransform_")) {
    require_count(6);
    const bool zyx = block.fixed.size() >= 4 && block.fixed[3] != 0.0;
    parts.matrix = FromEuler(vector_at(0), zyx);
    parts.translation = vector_at(3);
  } else if (is("VersorRigid3DTransform_")) {
    require_count(6);
    parts.matrix = FromVersor(vector_at(0), file);
    parts.translation = vector_at(3);
  } else if (is("QuaternionRigidTransform_")) {
    require_count(7);
    const Eigen::Quaterniond rotation(p[3], p[0], p[1], p[2]);
    ACUS_REQUIRE(std::abs(rotation.norm() - 1.0) < 1e-3, file, ": the quaternion's length is ",
                 rotation.norm(), ", not 1");
    parts.matrix = rotation.normalized().toRotationMatrix();
    parts.translation = vector_at(4);
  } else if (is("TranslationTransform_")) {
    require_count(3);
    parts.translation = vector_at(0);
  } else {
    ACUS_REQUIRE(is("IdentityTransform_"), file, ": transform '", block.type.substr(0, 60),
                 "' is not read here; Affine, Euler3D, VersorRigid3D, QuaternionRigid, Translation "
                 "and Identity are");
  }
  return parts;
}

Matrix4d MatrixOf(const ItkTransform& block, const std::string& file) {
  ACUS_REQUIRE(block.type.ends_with("_3_3"), file, ": transform '", block.type.substr(0, 60),
               "' is not three-dimensional");
  const Parts parts = PartsOf(block, file);
  Vector3d centre = Vector3d::Zero();
  if (block.fixed.size() >= 3) centre = Vector3d(block.fixed.data());
  Matrix4d matrix = Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = parts.matrix;
  matrix.topRightCorner<3, 1>() = parts.translation + centre - parts.matrix * centre;
  return matrix;
}

/// A composite transform applies the last of its parts first, as ITK does.
Eigen::Isometry3d Composed(std::vector<ItkTransform> transforms, const std::string& file) {
  const bool is_composite = !transforms.empty() && transforms.front().type.starts_with(kComposite);
  if (is_composite) transforms.erase(transforms.begin());
  ACUS_REQUIRE(!transforms.empty(), file, ": has no transform");
  ACUS_REQUIRE(is_composite || transforms.size() == 1, file, ": holds ", transforms.size(),
               " transforms; save the one that is meant");
  Matrix4d matrix = Matrix4d::Identity();
  for (const ItkTransform& part : transforms) matrix = matrix * MatrixOf(part, file);
  return RigidWithin(matrix, file);
}

}  // namespace

void WriteTransform(const std::filesystem::path& path, const Eigen::Isometry3d& target_from_source,
                    std::string_view comment) {
  ACUS_REQUIRE(math::IsRigid(target_from_source.matrix()), path.string(),
               ": the transform to be written is not rigid");
  std::string text = Message(kMagic, "\n#Transform 0\n# ", comment.substr(0, comment.find('\n')),
                             "\nTransform: AffineTransform_double_3_3\nParameters:");
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      text += " " + NumberText(target_from_source(row, column));
    }
  }
  for (int row = 0; row < 3; ++row) text += " " + NumberText(target_from_source(row, 3));
  WriteTextFile(path, text + "\nFixedParameters: 0 0 0\n");
}

Eigen::Isometry3d ReadTransform(const std::filesystem::path& path) {
  const std::string text = ReadTextFile(path);
  if (text.starts_with(kMagic)) return Composed(TextTransforms(text, path.string()), path.string());
  if (text.starts_with("\x89HDF")) {
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(text.data());
    return Composed(ReadItkTransforms({bytes, text.size()}, path.string()), path.string());
  }
  return ParseRigidMatrix(text, path.string());
}

Eigen::Isometry3d ParseRigidMatrix(std::string_view text, const std::string& label) {
  ACUS_REQUIRE(text.size() <= 10000, label, ": is not a transform: neither '", kMagic,
               "' nor 16 numbers");
  const std::string matrix_text = WithoutComments(Utf8Text(std::string(text), label));
  const TableStyle style = StyleOf(matrix_text, label);
  ACUS_REQUIRE(!style.has_decimal_comma, label,
               ": has decimal commas; write the 16 numbers with a decimal point");
  const auto begin = std::min(matrix_text.find_first_not_of(" \t\r\n"), matrix_text.size());
  const bool is_numbers =
      std::string_view("+-.0123456789").find(matrix_text[begin]) != std::string_view::npos;
  ACUS_REQUIRE(begin == matrix_text.size() || is_numbers, label,
               ": is no transform that is read: neither '", kMagic,
               "' (ITK, 3D Slicer) nor 16 numbers (4 x 4, row by row); it begins with '",
               std::string_view(matrix_text).substr(begin, 30), "'");
  const std::vector<double> numbers = Numbers(matrix_text, label);
  ACUS_REQUIRE(numbers.size() == 16, label, ": 16 numbers (4 x 4, row by row) are needed, got ",
               numbers.size());
  const Matrix4d matrix =
      Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers.data());
  return RigidWithin(matrix, label);
}

}  // namespace acus::transforms
