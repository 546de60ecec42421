#pragma once

#include <memory>
#include <string>

#include "loader/node.h"

namespace kinome::loader {

/// A <transform> that is as near to a matrix as the steps of the one that the scene's text says can
/// come to it by a change of the last: a <lookat>, or a <translate>, which is added where the last
/// is neither. nullptr: that is not near enough. `written`: what the text says; nullptr: nothing.
/// `name`: of the parameter.
std::shared_ptr<Node> placed_transform(const Node* written, const std::string& name,
                                       const Mat4& matrix, const Location& where);

}  // namespace kinome::loader
