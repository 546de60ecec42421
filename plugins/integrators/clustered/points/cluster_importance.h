#pragma once

#include <memory>

#include "clustered/points/light_cut.h"

namespace kinome {

/// Importance function Gamma over the clusters of a cut (Åkerlund 2008, 3.1). Its normalised values
/// (eq. 3.1) are the distribution from which light is drawn.
class ClusterImportance {
 public:
  virtual ~ClusterImportance() = default;
  /// Prepares weigh() for the clusters of `cut`, which must outlive this object. Called once.
  virtual void prepare(const LightCut& cut) = 0;
  /// Returns the distribution for a shading point: `pmf`, which is set, or one that prepare() made.
  /// Thread-safe.
  virtual const ClusterPmf& weigh(const LightCut::Point& point, ClusterPmf& pmf) const = 0;
  /// False if weigh() ignores the point: callers then needn't compute it.
  virtual bool uses_point() const { return true; }
};

/// Importance functions of the thesis, each in a file of its own.
std::unique_ptr<ClusterImportance> make_joint_importance();
std::unique_ptr<ClusterImportance> make_luminance_importance();
std::unique_ptr<ClusterImportance> make_brdf_importance();
using MakeClusterImportance = decltype(make_joint_importance);

}  // namespace kinome
