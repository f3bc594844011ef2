// The viewer's GLSL, embedded in the binary at build from viewer/shaders.
#pragma once

#include <initializer_list>
#include <string>

#include <osg/Program>
#include <osg/ref_ptr>

namespace palp {

// Files in this directory win over the embedded ones. Empty: embedded only. Call before the first load_program.
void set_shader_directory(const std::string& directory);

// A program of the named files ("mesh.vert", "mesh.frag", "lighting.glsl"); the ending says the stage, .glsl is a part
// of the stage of the file before it. Throws std::runtime_error naming the file when there is none.
osg::ref_ptr<osg::Program> load_program(const std::string& name, std::initializer_list<const char*> files);

}  // namespace palp
