#include "viewer/shaders.h"

#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string_view>

#include <osg/Shader>

namespace palp {
namespace {

struct EmbeddedShader {
  std::string_view file;
  std::string_view text;
};

constexpr EmbeddedShader kEmbedded[] = {
#include "embedded_shaders.inc"
};

std::string& shader_directory() {
  static std::string directory;
  return directory;
}

std::string source_of(const std::string& file) {
  if (!shader_directory().empty()) {
    std::ifstream in(shader_directory() + "/" + file);
    if (in) {
      std::ostringstream text;
      text << in.rdbuf();
      return text.str();
    }
  }
  for (const EmbeddedShader& shader : kEmbedded) {
    if (shader.file == file) return std::string(shader.text);
  }
  throw std::runtime_error("shader " + file + " is not part of this viewer");
}

}  // namespace

void set_shader_directory(const std::string& directory) { shader_directory() = directory; }

osg::ref_ptr<osg::Program> load_program(const std::string& name, std::initializer_list<const char*> files) {
  osg::ref_ptr<osg::Program> program = new osg::Program;
  program->setName(name);
  bool vertex = true;
  for (const char* file : files) {
    if (!std::string_view(file).ends_with(".glsl")) vertex = std::string_view(file).ends_with(".vert");
    osg::ref_ptr<osg::Shader> shader =
        new osg::Shader(vertex ? osg::Shader::VERTEX : osg::Shader::FRAGMENT, source_of(file));
    shader->setName(file);
    program->addShader(shader);
  }
  return program;
}

}  // namespace palp
