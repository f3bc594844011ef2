// How what one can see through is drawn.
#pragma once

#include <osg/BlendFunc>
#include <osg/Depth>
#include <osg/StateSet>

namespace palp {

// Mixes by alpha with what lies behind, and hides nothing that is drawn later.
inline void blend_over(osg::StateSet* state) {
  state->setAttributeAndModes(new osg::BlendFunc(osg::BlendFunc::SRC_ALPHA, osg::BlendFunc::ONE_MINUS_SRC_ALPHA));
  state->setAttributeAndModes(new osg::Depth(osg::Depth::LESS, 0, 1, false));
}

}  // namespace palp
