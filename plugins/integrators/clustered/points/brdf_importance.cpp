#include "clustered/points/cluster_importance.h"

namespace kinome {
namespace {

/// Importance of the BRDF (Åkerlund 2008, 3.1.2): its metric (eq. 4.5) times the form factor G. The
/// cluster's solid angle or area replaces the summed luminance, because it grows with the number of
/// points as well.
class BrdfImportance final : public ClusterImportance {
 public:
  void prepare(const LightCut& cut) override { cut_ = &cut; }
  const ClusterPmf& weigh(const LightCut::Point& point, ClusterPmf& pmf) const override {
    cut_->weigh_reflected(cut_->extents(), point, pmf);
    return pmf;
  }

 private:
  const LightCut* cut_ = nullptr;
};

}  // namespace

std::unique_ptr<ClusterImportance> make_brdf_importance() {
  return std::make_unique<BrdfImportance>();
}

}  // namespace kinome
