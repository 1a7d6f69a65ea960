#include "acus/imaging/graphics/gl_objects.h"

#define GL_GLEXT_PROTOTYPES
#include <GL/glcorearb.h>
#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "acus/base/core/error.h"

namespace acus::graphics {
namespace {

struct TexelLayout {
  GLenum on_card;
  GLenum channels;
  GLenum type;
  int bytes;
};

thread_local std::uint64_t bytes_sent = 0;

TexelLayout LayoutOf(TexelFormat format) {
  switch (format) {
    case TexelFormat::kShort:
      return {GL_R16_SNORM, GL_RED, GL_SHORT, 2};
    case TexelFormat::kShort4:
      return {GL_RGBA16_SNORM, GL_RGBA, GL_SHORT, 8};
    case TexelFormat::kByte4:
      return {GL_RGBA8_SNORM, GL_RGBA, GL_BYTE, 4};
    case TexelFormat::kIndex:
      return {GL_R8UI, GL_RED_INTEGER, GL_UNSIGNED_BYTE, 1};
    case TexelFormat::kFloat:
      return {GL_R32F, GL_RED, GL_FLOAT, 4};
    case TexelFormat::kFloat3:
      return {GL_RGB32F, GL_RGB, GL_FLOAT, 12};
  }
  return {};
}

TexelLayout LayoutOf(PixelFormat format) {
  switch (format) {
    case PixelFormat::kGrey:
      return {GL_R8, GL_RED, GL_UNSIGNED_BYTE, 1};
    case PixelFormat::kHalf4:
      return {GL_RGBA16F, GL_RGBA, GL_HALF_FLOAT, 8};
    case PixelFormat::kFloat:
      return {GL_R32F, GL_RED, GL_FLOAT, 4};
    case PixelFormat::kDepth:
      return {GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT, 4};
  }
  return {};
}

void RequireTexture(GLenum limit, int most_along, const char* what) {
  GLint most = 0;
  glGetIntegerv(limit, &most);
  ACUS_REQUIRE(most_along <= most, "graphics card: ", what, " of ", most_along,
               " texels along an axis; its driver allows ", most);
}

GLenum KindOf(ShaderStage stage) {
  switch (stage) {
    case ShaderStage::kCompute:
      return GL_COMPUTE_SHADER;
    case ShaderStage::kVertex:
      return GL_VERTEX_SHADER;
    case ShaderStage::kFragment:
      return GL_FRAGMENT_SHADER;
  }
  return 0;
}

std::string LogOf(GLuint shader) {
  std::string log(2000, '\0');
  GLsizei length = 0;
  glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), &length, log.data());
  log.resize(static_cast<std::size_t>(length));
  return log;
}

}  // namespace

Texture::~Texture() {
  glDeleteTextures(1, &name_);
}

Texture::Texture(Texture&& other) noexcept {
  *this = std::move(other);
}

Texture& Texture::operator=(Texture&& other) noexcept {
  std::swap(name_, other.name_);
  std::swap(format_, other.format_);
  std::swap(size_, other.size_);
  return *this;
}

void Texture::Resize(TexelFormat format, const Eigen::Array3i& size) {
  if (name_ == 0 || format != format_ || (size != size_).any()) {
    RequireTexture(GL_MAX_3D_TEXTURE_SIZE, size.maxCoeff(), "a volume");
    glDeleteTextures(1, &name_);
    glCreateTextures(GL_TEXTURE_3D, 1, &name_);
    glTextureStorage3D(name_, 1, LayoutOf(format).on_card, size[0], size[1], size[2]);
    const GLint filter = format == TexelFormat::kIndex ? GL_NEAREST : GL_LINEAR;
    glTextureParameteri(name_, GL_TEXTURE_MIN_FILTER, filter);
    glTextureParameteri(name_, GL_TEXTURE_MAG_FILTER, filter);
    for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R}) {
      glTextureParameteri(name_, axis, GL_CLAMP_TO_EDGE);
    }
    format_ = format;
    size_ = size;
  }
}

void Texture::Set(TexelFormat format, const Eigen::Array3i& size, const void* values) {
  Resize(format, size);
  const TexelLayout layout = LayoutOf(format);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureSubImage3D(name_, 0, 0, 0, 0, size[0], size[1], size[2], layout.channels, layout.type,
                      values);
  bytes_sent += static_cast<std::uint64_t>(layout.bytes) * static_cast<std::uint64_t>(size.prod());
}

void Texture::Fill(std::uint8_t value) {
  glClearTexImage(name_, 0, GL_RED_INTEGER, GL_UNSIGNED_BYTE, &value);
}

void Texture::Bind(unsigned unit) const {
  glBindTextureUnit(unit, name_);
}

void Texture::BindForWriting(unsigned unit) const {
  glBindImageTexture(unit, name_, 0, GL_TRUE, 0, GL_READ_WRITE, GL_R8UI);
}

Buffer::~Buffer() {
  glDeleteBuffers(1, &name_);
}

void Buffer::Set(const void* values, std::size_t num_bytes) {
  if (name_ == 0) glCreateBuffers(1, &name_);
  if (num_bytes > num_bytes_) {
    GLint64 most = 0;
    glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &most);
    ACUS_REQUIRE(num_bytes <= static_cast<std::size_t>(most), "graphics card: ", num_bytes,
                 " bytes for one image; its driver allows ", most);
    glNamedBufferData(name_, static_cast<GLsizeiptr>(num_bytes), nullptr, GL_DYNAMIC_DRAW);
    num_bytes_ = num_bytes;
  }
  if (values != nullptr && num_bytes > 0) {
    glNamedBufferSubData(name_, 0, static_cast<GLsizeiptr>(num_bytes), values);
    bytes_sent += num_bytes;
  }
}

void Buffer::Clear(std::size_t num_bytes) {
  Set(nullptr, num_bytes);
  glClearNamedBufferSubData(name_, GL_R32UI, 0, static_cast<GLsizeiptr>(num_bytes), GL_RED_INTEGER,
                            GL_UNSIGNED_INT, nullptr);
}

void Buffer::BindUniforms(unsigned binding) const {
  glBindBufferBase(GL_UNIFORM_BUFFER, binding, name_);
}

void Buffer::Bind(unsigned binding) const {
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, name_);
}

void Buffer::Read(void* values, std::size_t num_bytes) const {
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  glGetNamedBufferSubData(name_, 0, static_cast<GLsizeiptr>(num_bytes), values);
}

ImageTexture::~ImageTexture() {
  glDeleteTextures(1, &name_);
}

void ImageTexture::Resize(PixelFormat format, int width_px, int height_px) {
  if (name_ != 0 && format == format_ && width_px == width_px_ && height_px == height_px_) return;
  RequireTexture(GL_MAX_TEXTURE_SIZE, std::max(width_px, height_px), "an image");
  glDeleteTextures(1, &name_);
  glCreateTextures(GL_TEXTURE_2D, 1, &name_);
  glTextureStorage2D(name_, 1, LayoutOf(format).on_card, width_px, height_px);
  const GLint filter = format == PixelFormat::kGrey ? GL_LINEAR : GL_NEAREST;
  glTextureParameteri(name_, GL_TEXTURE_MIN_FILTER, filter);
  glTextureParameteri(name_, GL_TEXTURE_MAG_FILTER, filter);
  for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T}) {
    glTextureParameteri(name_, axis, GL_CLAMP_TO_EDGE);
  }
  format_ = format;
  width_px_ = width_px;
  height_px_ = height_px;
}

void ImageTexture::Write(const void* values) {
  const TexelLayout layout = LayoutOf(format_);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureSubImage2D(name_, 0, 0, 0, width_px_, height_px_, layout.channels, layout.type, values);
  bytes_sent += static_cast<std::uint64_t>(layout.bytes) * static_cast<std::uint64_t>(width_px_) *
                static_cast<std::uint64_t>(height_px_);
}

void ImageTexture::Bind(unsigned unit) const {
  glBindTextureUnit(unit, name_);
}

Canvas::Canvas() {
  glCreateFramebuffers(1, &name_);
}
Canvas::~Canvas() {
  glDeleteFramebuffers(1, &name_);
}

void Canvas::Attach(std::initializer_list<const ImageTexture*> colours, const ImageTexture* depth) {
  std::vector<GLenum> places;
  for (const ImageTexture* colour : colours) {
    places.push_back(GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(places.size()));
    glNamedFramebufferTexture(name_, places.back(), colour->name(), 0);
  }
  glNamedFramebufferTexture(name_, GL_DEPTH_ATTACHMENT, depth == nullptr ? 0 : depth->name(), 0);
  glNamedFramebufferDrawBuffers(name_, static_cast<GLsizei>(places.size()), places.data());
  ACUS_REQUIRE(glCheckNamedFramebufferStatus(name_, GL_DRAW_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE,
               "graphics card: its driver does not draw into images of these formats");
}

void Canvas::Clear(int colour, float value) {
  const std::array values{value, value, value, value};
  glClearNamedFramebufferfv(name_, GL_COLOR, colour, values.data());
}

void Canvas::ClearDepth(float value) {
  glClearNamedFramebufferfv(name_, GL_DEPTH, 0, &value);
}

void Canvas::Use(int width_px, int height_px) const {
  glBindFramebuffer(GL_FRAMEBUFFER, name_);
  glViewport(0, 0, width_px, height_px);
}

Mesh::Mesh() {
  glCreateVertexArrays(1, &name_);
  const std::array<std::pair<GLint, GLuint>, 3> members{{
      {3, offsetof(MeshVertex, place_mm)},
      {3, offsetof(MeshVertex, normal)},
      {2, offsetof(MeshVertex, texel)},
  }};
  for (GLuint n = 0; n < members.size(); ++n) {
    glEnableVertexArrayAttrib(name_, n);
    glVertexArrayAttribFormat(name_, n, members[n].first, GL_FLOAT, GL_FALSE, members[n].second);
    glVertexArrayAttribBinding(name_, n, 0);
  }
}

Mesh::~Mesh() {
  glDeleteVertexArrays(1, &name_);
}

void Mesh::Set(std::span<const MeshVertex> vertices, std::span<const std::uint32_t> corners) {
  vertices_.Set(vertices.data(), vertices.size_bytes());
  corners_.Set(corners.data(), corners.size_bytes());
  glVertexArrayVertexBuffer(name_, 0, vertices_.name(), 0, sizeof(MeshVertex));
  glVertexArrayElementBuffer(name_, corners_.name());
}

void Mesh::Draw(std::size_t first_corner, std::size_t count) const {
  glBindVertexArray(name_);
  glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(count), GL_UNSIGNED_INT,
                 reinterpret_cast<const void*>(first_corner * sizeof(std::uint32_t)));
}

Program::Program(std::initializer_list<ShaderText> shaders) : name_(glCreateProgram()) {
  std::string trouble;
  for (const ShaderText& text : shaders) {
    const GLuint shader = glCreateShader(KindOf(text.stage));
    const char* source = text.source.c_str();
    glShaderSource(shader, 1, &source, nullptr);
    glCompileShader(shader);
    GLint good = GL_FALSE;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &good);
    if (good != GL_TRUE) trouble += LogOf(shader);
    glAttachShader(name_, shader);
    glDeleteShader(shader);
  }
  glLinkProgram(name_);
  GLint good = GL_FALSE;
  glGetProgramiv(name_, GL_LINK_STATUS, &good);
  if (good == GL_TRUE && trouble.empty()) return;
  std::string log(2000, '\0');
  GLsizei length = 0;
  glGetProgramInfoLog(name_, static_cast<GLsizei>(log.size()), &length, log.data());
  log.resize(static_cast<std::size_t>(length));
  glDeleteProgram(name_);
  throw InputError("graphics card: its driver does not compile the shader: " + trouble + log);
}

Program::~Program() {
  glDeleteProgram(name_);
}

void Program::Set(const char* name, int value) {
  glProgramUniform1i(name_, glGetUniformLocation(name_, name), value);
}
void Program::Set(const char* name, const Eigen::Vector4f& value) {
  glProgramUniform4fv(name_, glGetUniformLocation(name_, name), 1, value.data());
}

void Program::Set(const char* name, const Eigen::Vector4i& value) {
  glProgramUniform4iv(name_, glGetUniformLocation(name_, name), 1, value.data());
}

void Program::Use() const {
  glUseProgram(name_);
}

void Program::Run(const Eigen::Array3i& groups) const {
  glUseProgram(name_);
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT |
                  GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
  glDispatchCompute(static_cast<GLuint>(groups[0]), static_cast<GLuint>(groups[1]),
                    static_cast<GLuint>(groups[2]));
}

std::uint64_t BytesSent() {
  return bytes_sent;
}

}  // namespace acus::graphics
