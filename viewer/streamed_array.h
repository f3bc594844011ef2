// An array of vertices that changes from picture to picture and is copied to the GPU in pieces (gpu_pacing.h), where
// OSG would copy all of it at once.
#pragma once

#include <cstddef>

#include <osg/Array>
#include <osg/BufferObject>
#include <osg/GLExtensions>
#include <osg/State>

#include "viewer/gpu_pacing.h"

namespace palp {

// Array: osg::Vec4Array or the like, which has a buffer of its own.
template <class Array>
class StreamedArray : public Array {
 public:
  StreamedArray() {
    this->setVertexBufferObject(new osg::VertexBufferObject);
    this->getVertexBufferObject()->setUsage(GL_STREAM_DRAW);
  }

  // Has what was put into it since it was cleared copied before it is drawn. It gets elements without use behind that,
  // so that its buffer on the GPU, which OSG makes and fills anew when it grows, seldom has to.
  void changed() {
    used_ = this->size();
    stale_ = used_ <= room_;
    if (!stale_) {
      room_ = used_ + used_ / 4;
      this->dirty();
    }
    this->resize(room_);
  }

  // Copies what has changed; to be called before it is drawn, each time.
  void copy(osg::RenderInfo& info) const {
    osg::State& state = *info.getState();
    osg::GLBufferObject* buffer = this->getVertexBufferObject()->getGLBufferObject(state.getContextID());
    if (!stale_ || buffer == nullptr || buffer->isDirty()) return skip_pieces(info);
    stale_ = false;
    state.unbindVertexBufferObject();  // from here on OSG knows of no bound buffer, as is the case at the end
    in_pieces(info, kMostPieces, [&](int k, int n) {
      const std::size_t from = used_ * static_cast<std::size_t>(k) / static_cast<std::size_t>(n);
      const std::size_t to = used_ * static_cast<std::size_t>(k + 1) / static_cast<std::size_t>(n);
      constexpr std::size_t kSize = sizeof(typename Array::ElementDataType);
      buffer->bindBuffer();
      state.get<osg::GLExtensions>()->glBufferSubData(GL_ARRAY_BUFFER_ARB, static_cast<GLintptr>(from * kSize),
                                                      static_cast<GLsizeiptr>((to - from) * kSize),
                                                      this->asVector().data() + from);
    });
    buffer->unbindBuffer();
  }

 private:
  static constexpr int kMostPieces = 16;
  std::size_t used_ = 0, room_ = 0;
  mutable bool stale_ = false;  // what OpenGL has is older
};

}  // namespace palp
