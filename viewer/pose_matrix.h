// Poses of messages as OSG's matrices.
#pragma once

#include <osg/Matrixd>

#include "idl/messages.h"

namespace palp {

// Returns false if the pose is none: not finite, or without an orientation.
bool pose_matrix(const PoseD& pose, osg::Matrixd& out);

}  // namespace palp
