#include "clustered/points/cluster_importance.h"

namespace kinome {
namespace {

/// Joint importance (Åkerlund 2008, 3.1.3 and 4.2): luminance of the cluster, summed over its
/// points, times the form factor G and the BRDF's metric (eq. 4.5).
class JointImportance final : public ClusterImportance {
 public:
  void prepare(const LightCut& cut) override { cut_ = &cut; }
  const ClusterPmf& weigh(const LightCut::Point& point, ClusterPmf& pmf) const override {
    cut_->weigh_reflected(cut_->luminances(), point, pmf);
    return pmf;
  }

 private:
  const LightCut* cut_ = nullptr;
};

}  // namespace

std::unique_ptr<ClusterImportance> make_joint_importance() {
  return std::make_unique<JointImportance>();
}

}  // namespace kinome
