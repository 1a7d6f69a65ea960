// Textures, buffers, meshes and programs of the current OpenGL context, each freed with its owner.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>

namespace acus::graphics {

/// How values lie in a texture of three dimensions, here and on the card.
enum class TexelFormat {
  kShort,   ///< One signed value of 16 bits, read as value / 32767.
  kShort4,  ///< Four of them.
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
  /// The same without values.
  void Resize(TexelFormat format, const Eigen::Array3i& size);
  /// @pre kIndex.
  void Fill(std::uint8_t value);
  void Bind(unsigned unit) const;
  /// As an image that shaders read and write. @pre kIndex.
  void BindForWriting(unsigned unit) const;

 private:
  unsigned name_ = 0;
  TexelFormat format_ = TexelFormat::kShort;
  Eigen::Array3i size_ = Eigen::Array3i::Zero();
};

enum class PixelFormat {
  kGrey,   ///< 8 bits, read as value / 255.
  kHalf4,  ///< Four numbers of 16 bits.
  kFloat,
  kDepth,
};

/// A texture of two dimensions: what is drawn, or looked up.
class ImageTexture {
 public:
  ImageTexture() = default;
  ~ImageTexture();
  ImageTexture(const ImageTexture&) = delete;
  ImageTexture& operator=(const ImageTexture&) = delete;

  /// Its values are lost if the size changes. @throws InputError if the card takes none of that
  /// size.
  void Resize(PixelFormat format, int width_px, int height_px);
  /// @param values  Row by row, nothing between rows.
  void Write(const void* values);
  void Bind(unsigned unit) const;
  unsigned name() const { return name_; }

 private:
  unsigned name_ = 0;
  PixelFormat format_ = PixelFormat::kGrey;
  int width_px_ = 0;
  int height_px_ = 0;
};

/// Where a program draws to.
class Canvas {
 public:
  Canvas();
  ~Canvas();
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;

  /// Until the next call; they must stay. @param depth  May be null.
  void Attach(std::initializer_list<const ImageTexture*> colours, const ImageTexture* depth);
  void Clear(int colour, float value);
  void ClearDepth(float value);
  /// What is drawn from now on goes here.
  void Use(int width_px, int height_px) const;

 private:
  unsigned name_ = 0;
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
  /// The first bytes become 0.
  void Clear(std::size_t num_bytes);
  void Bind(unsigned binding) const;
  void BindUniforms(unsigned binding) const;
  /// Waits for what writes it.
  void Read(void* values, std::size_t num_bytes) const;
  unsigned name() const { return name_; }

 private:
  unsigned name_ = 0;
  std::size_t num_bytes_ = 0;
};

struct MeshVertex {
  Eigen::Vector3f place_mm;
  Eigen::Vector3f normal;
  Eigen::Vector2f texel;  ///< Column and row.
};

/// Triangles: attributes 0 to 2 of a vertex shader are the members of MeshVertex.
class Mesh {
 public:
  Mesh();
  ~Mesh();
  Mesh(const Mesh&) = delete;
  Mesh& operator=(const Mesh&) = delete;

  void Set(std::span<const MeshVertex> vertices, std::span<const std::uint32_t> corners);
  /// Triangles of `count` corners.
  void Draw(std::size_t first_corner, std::size_t count) const;

 private:
  unsigned name_ = 0;
  Buffer vertices_;
  Buffer corners_;
};

enum class ShaderStage { kCompute, kVertex, kFragment };
struct ShaderText {
  ShaderStage stage;
  std::string source;
};

/// Shaders with their uniforms by name; names that they do not use are ignored.
class Program {
 public:
  /// @throws InputError with the driver's words if it does not compile.
  Program(std::initializer_list<ShaderText> shaders);
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  void Set(const char* name, int value);
  void Set(const char* name, const Eigen::Vector4f& value);
  void Set(const char* name, const Eigen::Vector4i& value);
  void Use() const;
  /// A compute shader, after whatever wrote what it reads.
  void Run(const Eigen::Array3i& groups) const;

 private:
  unsigned name_ = 0;
};

/// Bytes that this thread has sent to the card so far.
std::uint64_t BytesSent();

}  // namespace acus::graphics
