// Catmull-Rom cubics: sharper than Mitchell and Netravali's choice, with more ringing. Has negative
// lobes.
//
//   <rfilter type="catmullrom"/>

#include "cubic.h"
#include "kinome/plugin.h"

namespace kinome {
namespace {

class CatmullRomFilter final : public CubicFilter {
 public:
  explicit CatmullRomFilter(const Properties&) : CubicFilter(0, 0.5f) {}
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::CatmullRomFilter, kinome::Category::kReconstructionFilter, "catmullrom",
              "Catmull-Rom cubics: sharper than mitchell, with more ringing.", {});
