// The font of all words in the picture.
#pragma once

#include <string>

#include <osg/ref_ptr>
#include <osgText/Font>

namespace palp {

// Returns the file of the font that find_font() reads; empty for OSG's built-in one.
std::string find_font_file();

// Returns the font of the file that PALP_FONT names, else DejaVu Sans (fonts-dejavu-core). Returns null, which stands
// for OSG's built-in font, with one warning where neither is found, and without one for PALP_FONT=plain.
osg::ref_ptr<osgText::Font> find_font();

}  // namespace palp
