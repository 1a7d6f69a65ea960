// Textures, buffers and programs of the current OpenGL context, each freed with its owner.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>

namespace acus::graphics {

/// How values lie in a texture of three dimensions, here and on the card.
enum class TexelFormat {
  kShort,   ///< One signed value of 16 bits, read as value / 32767.
  kShort3,  ///< Three of them.
  kByte4,   ///< Four signed values of 8 bits, read as value / 127.
  kIndex,   ///< An unsigned value of 8 bits, read as it is.
  kFloat,   ///< As it is.
  kFloat3,
};

/// Trilinear between the centres of texels, except for kIndex, and as at its border beyond.
class Texture {
 public:
  Texture() = default;
  ~Texture();
  Texture(Texture&& other) noexcept;
  Texture& operator=(Texture&& other) noexcept;

  /// Whatever was before. x runs fastest, nothing between rows.
  /// @throws InputError if the card takes no texture of that size.
  void Set(TexelFormat format, const Eigen::Array3i& size, const void* values);
  void Bind(unsigned unit) const;

 private:
  unsigned name_ = 0;
  TexelFormat format_ = TexelFormat::kShort;
  Eigen::Array3i size_ = Eigen::Array3i::Zero();
};

/// Memory that a shader reads or writes.
class Buffer {
 public:
  Buffer() = default;
  ~Buffer();
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;

  /// @param values  Null: not set. @throws InputError if it is larger than the card allows.
  void Set(const void* values, std::size_t num_bytes);
  void Bind(unsigned binding) const;
  /// Waits for what writes it.
  void Read(void* values, std::size_t num_bytes) const;

 private:
  unsigned name_ = 0;
  std::size_t num_bytes_ = 0;
};

/// A compute shader with its uniforms by name; names that it does not use are ignored.
class ComputeProgram {
 public:
  /// @throws InputError with the driver's words if it does not compile.
  explicit ComputeProgram(const std::string& source);
  ~ComputeProgram();
  ComputeProgram(const ComputeProgram&) = delete;
  ComputeProgram& operator=(const ComputeProgram&) = delete;

  void Set(const char* name, int value);
  void Set(const char* name, float value);
  void Set(const char* name, const Eigen::Vector2f& value);
  void Set(const char* name, const Eigen::Vector3f& value);
  void Set(const char* name, const Eigen::Vector4f& value);
  void Set(const char* name, const Eigen::Array3i& value);
  void Set(const char* name, const Eigen::Matrix3f& value);
  void Run(int groups_x, int groups_y) const;

 private:
  int Location(const char* name) const;
  unsigned name_ = 0;
};

}  // namespace acus::graphics
