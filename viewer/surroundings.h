// The background of the picture and the ground below the scene.
#pragma once

#include <osg/Geometry>
#include <osg/Node>
#include <osg/ref_ptr>

namespace palp {

osg::ref_ptr<osg::Node> make_background();
// Returns a ground whose vertices and uniforms footprint, fade and cell are to be set by where the scene is.
osg::ref_ptr<osg::Geometry> make_ground();

}  // namespace palp
