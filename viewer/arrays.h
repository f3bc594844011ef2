// OSG arrays from lists of values.
#pragma once

#include <initializer_list>

#include <osg/Array>

namespace palp {

template <class Array>
osg::ref_ptr<Array> array_of(std::initializer_list<typename Array::ElementDataType> values) {
  return new Array(values.begin(), values.end());
}

}  // namespace palp
