#pragma once

namespace kinome {

/// Thrown to cancel an item (RenderJob::check_interrupt()).
struct ItemCancelled {};

}  // namespace kinome
