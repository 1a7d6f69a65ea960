#include "acus/imaging/graphics/gl_objects.h"

#define GL_GLEXT_PROTOTYPES
#include <GL/glcorearb.h>
#include <utility>

#include "acus/base/core/error.h"

namespace acus::graphics {
namespace {

struct TexelLayout {
  GLenum on_card;
  GLenum channels;
  GLenum type;
};

TexelLayout LayoutOf(TexelFormat format) {
  switch (format) {
    case TexelFormat::kShort:
      return {GL_R16_SNORM, GL_RED, GL_SHORT};
    case TexelFormat::kShort3:
      return {GL_RGB16_SNORM, GL_RGB, GL_SHORT};
    case TexelFormat::kByte4:
      return {GL_RGBA8_SNORM, GL_RGBA, GL_BYTE};
    case TexelFormat::kIndex:
      return {GL_R8UI, GL_RED_INTEGER, GL_UNSIGNED_BYTE};
    case TexelFormat::kFloat:
      return {GL_R32F, GL_RED, GL_FLOAT};
    case TexelFormat::kFloat3:
      return {GL_RGB32F, GL_RGB, GL_FLOAT};
  }
  return {};
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

void Texture::Set(TexelFormat format, const Eigen::Array3i& size, const void* values) {
  const TexelLayout layout = LayoutOf(format);
  if (name_ == 0 || format != format_ || (size != size_).any()) {
    GLint most = 0;
    glGetIntegerv(GL_MAX_3D_TEXTURE_SIZE, &most);
    ACUS_REQUIRE((size <= most).all(), "graphics card: a volume of ", size[0], " x ", size[1],
                 " x ", size[2], "; its driver allows ", most, " along each axis");
    glDeleteTextures(1, &name_);
    glCreateTextures(GL_TEXTURE_3D, 1, &name_);
    glTextureStorage3D(name_, 1, layout.on_card, size[0], size[1], size[2]);
    const GLint filter = format == TexelFormat::kIndex ? GL_NEAREST : GL_LINEAR;
    glTextureParameteri(name_, GL_TEXTURE_MIN_FILTER, filter);
    glTextureParameteri(name_, GL_TEXTURE_MAG_FILTER, filter);
    for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R}) {
      glTextureParameteri(name_, axis, GL_CLAMP_TO_EDGE);
    }
    format_ = format;
    size_ = size;
  }
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureSubImage3D(name_, 0, 0, 0, 0, size[0], size[1], size[2], layout.channels, layout.type,
                      values);
}

void Texture::Bind(unsigned unit) const {
  glBindTextureUnit(unit, name_);
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
  }
}

void Buffer::Bind(unsigned binding) const {
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, name_);
}

void Buffer::Read(void* values, std::size_t num_bytes) const {
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  glGetNamedBufferSubData(name_, 0, static_cast<GLsizeiptr>(num_bytes), values);
}

ComputeProgram::ComputeProgram(const std::string& source) : name_(glCreateProgram()) {
  const GLuint shader = glCreateShader(GL_COMPUTE_SHADER);
  const char* text = source.c_str();
  glShaderSource(shader, 1, &text, nullptr);
  glCompileShader(shader);
  GLint good = GL_FALSE;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &good);
  const std::string log = good == GL_TRUE ? "" : LogOf(shader);
  glAttachShader(name_, shader);
  glLinkProgram(name_);
  glDeleteShader(shader);
  if (good == GL_TRUE) glGetProgramiv(name_, GL_LINK_STATUS, &good);
  if (good != GL_TRUE) {
    glDeleteProgram(name_);
    throw InputError("graphics card: its driver does not compile the shader: " + log);
  }
}

ComputeProgram::~ComputeProgram() {
  glDeleteProgram(name_);
}

int ComputeProgram::Location(const char* name) const {
  return glGetUniformLocation(name_, name);
}

void ComputeProgram::Set(const char* name, int value) {
  glProgramUniform1i(name_, Location(name), value);
}
void ComputeProgram::Set(const char* name, float value) {
  glProgramUniform1f(name_, Location(name), value);
}
void ComputeProgram::Set(const char* name, const Eigen::Vector2f& value) {
  glProgramUniform2fv(name_, Location(name), 1, value.data());
}
void ComputeProgram::Set(const char* name, const Eigen::Vector3f& value) {
  glProgramUniform3fv(name_, Location(name), 1, value.data());
}
void ComputeProgram::Set(const char* name, const Eigen::Vector4f& value) {
  glProgramUniform4fv(name_, Location(name), 1, value.data());
}
void ComputeProgram::Set(const char* name, const Eigen::Array3i& value) {
  glProgramUniform3iv(name_, Location(name), 1, value.data());
}
void ComputeProgram::Set(const char* name, const Eigen::Matrix3f& value) {
  glProgramUniformMatrix3fv(name_, Location(name), 1, GL_FALSE, value.data());
}

void ComputeProgram::Run(int groups_x, int groups_y) const {
  glUseProgram(name_);
  glDispatchCompute(static_cast<GLuint>(groups_x), static_cast<GLuint>(groups_y), 1);
}

}  // namespace acus::graphics
