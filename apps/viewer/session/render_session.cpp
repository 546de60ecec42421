#include "session/render_session.h"

#include <algorithm>

namespace kinome::viewer {
namespace {

template <class T>
const T* with_path(const std::vector<T>& all, const std::string& path) {
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const T& one) { return one.path == path; });
  return found == all.end() ? nullptr : &*found;
}

}  // namespace

const SceneParameter* SceneInfo::find(const std::string& path) const {
  return with_path(parameters, path);
}
const SceneParameter* SceneInfo::find_textured(const std::string& path) const {
  return with_path(textured, path);
}
const SceneObject* SceneInfo::find_object(const std::string& path) const {
  return with_path(objects, path);
}

PicturePointer RenderSession::picture() const {
  const std::lock_guard lock(mutex_);
  return picture_;
}
std::shared_ptr<const SceneInfo> RenderSession::info() const {
  const std::lock_guard lock(mutex_);
  return info_;
}
Status RenderSession::status() const {
  const std::lock_guard lock(mutex_);
  Status status = status_;
  status.fraction = fraction_;
  return status;
}
std::vector<Message> RenderSession::messages(uint64_t known) const {
  const std::lock_guard lock(mutex_);
  const auto first = std::find_if(messages_.begin(), messages_.end(),
                                  [&](const Message& message) { return message.number > known; });
  return {first, messages_.end()};
}

}  // namespace kinome::viewer
