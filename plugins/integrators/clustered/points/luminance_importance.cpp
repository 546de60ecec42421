#include "clustered/points/cluster_importance.h"

namespace kinome {
namespace {

/// Importance of luminance alone (Åkerlund 2008, 3.1.1), summed over the cluster's points (4.2). It
/// is the same for every shading point.
class LuminanceImportance final : public ClusterImportance {
 public:
  void prepare(const LightCut& cut) override { cut.weigh(cut.luminances(), pmf_); }
  const ClusterPmf& weigh(const LightCut::Point&, ClusterPmf&) const override { return pmf_; }
  bool uses_point() const override { return false; }

 private:
  ClusterPmf pmf_;
};

}  // namespace

std::unique_ptr<ClusterImportance> make_luminance_importance() {
  return std::make_unique<LuminanceImportance>();
}

}  // namespace kinome
