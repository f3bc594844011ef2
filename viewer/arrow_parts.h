// Shapes that arrows are made of.
#pragma once

#include <span>

#include <osg/Geometry>
#include <osg/Group>
#include <osg/Vec2f>
#include <osg/Vec4f>
#include <osg/ref_ptr>

namespace palp {

inline constexpr int kSidesOfArrows = 24;

// A surface of revolution about z through the rings (radius, z), normals from the slope between them.
osg::ref_ptr<osg::Geometry> revolve(std::span<const osg::Vec2f> profile, const osg::Vec4f& color);

// Draws the shape solid where it is seen and as a faint ghost where something hides it.
osg::ref_ptr<osg::Group> seen_and_hidden(osg::Node* shape);

}  // namespace palp
