#pragma once

#include <memory>
#include <string>

#include "scene_xml/nodes/node.h"

namespace kinome::loader {

/// Returns a <transform> that approximates `matrix` with the operations of the one in the scene's
/// text, `written` (may be nullptr). Only its last operation changes: a <lookat>, or a <translate>,
/// which is added if the last one is neither. Returns nullptr if the result isn't close enough.
/// `name` is the parameter's name.
std::shared_ptr<Node> placed_transform(const Node* written, const std::string& name,
                                       const Mat4& matrix, const Location& where);

}  // namespace kinome::loader
