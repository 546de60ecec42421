#include "queries.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "kinome/block_points.h"
#include "query_points.h"
#include "scene_queries.h"
#include "values.h"

namespace kinome::python {
namespace {

/// Fields of surface points, with a row per point. Those of rays that hit nothing are 0, but have a
/// frame along the axes.
struct Found {
  explicit Found(size_t count)
      : t(count, kInfinity), uv(2 * count), p_error(count), primitive(count), shape(count, kNoHit) {
    for (auto& values : triples) values.resize(3 * count);
  }
  void set(size_t row, const SurfaceBlock& points, size_t i) {
    for (size_t k = 0; k < kTriples; ++k) {
      set_row3(triples[k], row, (points.*kTripleColumns[k]).at(i));
    }
    uv[2 * row] = points.uv.x[i], uv[2 * row + 1] = points.uv.y[i];
    p_error[row] = points.p_error[i];
    primitive[row] = points.primitive[i];
  }
  void set_missed(size_t row, const Ray& ray) {
    for (size_t axis = 0; axis < 3; ++axis) triples[2 + axis][3 * row + axis] = 1;
    set_row3(triples[kTriples - 1], row, -ray.d);
  }

  std::vector<float> t;
  std::array<std::vector<float>, kTriples> triples;
  std::vector<float> uv, p_error;
  std::vector<uint32_t> primitive, shape;
};

void intersect_block(const Scene& scene, const float* rays, size_t first, size_t count,
                     Coherence coherence, Found& found) {
  std::vector<RayHit16> hits(padded(count) / kBlockLanes);
  read_rays(rays, first, count, hits);
  RenderCounters counters;
  scene.intersect(hits.data(), hits.size(), coherence, counters);
  const auto shape_of = [&](size_t i) -> const std::shared_ptr<Shape>* {
    const uint32_t shape = hits[i / kBlockLanes].shape[i % kBlockLanes];
    return shape == kNoHit ? nullptr : &scene.shapes()[shape];
  };
  for (size_t i = 0; i < count; ++i) {
    if (!shape_of(i)) {
      found.set_missed(first + i, ray_of(&hits[i / kBlockLanes].ray, i % kBlockLanes));
    }
  }
  for_each_group(count, shape_of, [&](const auto& shape, std::span<const uint32_t> rows) {
    Columns memory(rows.size());
    const SurfaceBlock points = memory.points(rows.size());
    for (size_t i = 0; i < padded(rows.size()); ++i) {
      points.ray[i] = rows[std::min(i, rows.size() - 1)];
    }
    shape->interaction_block(hits.data(), points);
    for (size_t i = 0; i < rows.size(); ++i) {
      found.set(first + rows[i], points, i);
      const RayHit hit = ray_hit_of(hits.data(), rows[i]);
      found.t[first + rows[i]] = hit.ray.tmax;
      found.shape[first + rows[i]] = hit.hit.shape;
    }
  });
}

/// Optional array: nullptr for None. The caller keeps the array alive.
const float* data_or_null(const nb::object& array) {
  return array.is_none() ? nullptr : nb::cast<Floats>(array, false).data();
}

/// Results of shade_points(), with a row per point.
struct Shaded {
  explicit Shaded(size_t count)
      : f(3 * count), pdf(count), wo(3 * count), weight(3 * count), sample_pdf(count),
        is_delta(count), eta(count, 1.f) {}
  std::vector<float> f, pdf, wo, weight, sample_pdf, is_delta, eta;
};

/// Input of shade_points() besides the points.
struct ShadeQuery {
  const float *wo, *u1, *u2;
  Lobe lobes;
};

void shade_group(const Bsdf& bsdf, const SurfaceBlock& points, std::span<const uint32_t> rows,
                 size_t first, const ShadeQuery& query, Columns& memory, Shaded& out) {
  BsdfQuery block;
  block.lobes = query.lobes;
  if (query.wo) {
    block.wo = memory.three();
    for (size_t i = 0; i < rows.size(); ++i) block.wo.set(i, row3(query.wo, first + rows[i]));
  }
  if (query.u1) {
    block.u1 = memory.one(), block.u2 = memory.two();
    for (size_t i = 0; i < rows.size(); ++i) {
      const size_t row = first + rows[i];
      block.u1[i] = query.u1[row];
      block.u2.set(i, {query.u2[2 * row], query.u2[2 * row + 1]});
    }
  }
  const BsdfAnswer answer{memory.three(), memory.one(), memory.three(),
                          memory.three(), memory.one(), memory.one()};
  bsdf.shade_block(points, block, answer);
  for (size_t i = 0; i < rows.size(); ++i) {
    const size_t row = first + rows[i];
    if (query.wo) set_row3(out.f, row, answer.f.at(i)), out.pdf[row] = answer.pdf[i];
    if (!query.u1 || !(answer.sample_pdf[i] > 0)) continue;
    set_row3(out.wo, row, answer.wo.at(i));
    set_row3(out.weight, row, answer.weight.at(i));
    out.sample_pdf[row] = answer.sample_pdf[i];
    out.is_delta[row] = answer.is_delta[i];
    if (answer.is_delta[i] == kNullSample || points.wi.z[i] * answer.wo.z[i] >= 0) continue;
    const float index = bsdf.relative_index();
    out.eta[row] = points.wi.z[i] > 0 ? index : 1 / index;
  }
}

/// Results of emission_of_points(), with a row per point.
struct Emitted {
  explicit Emitted(size_t count) : radiance(3 * count), pdf(count) {}
  std::vector<float> radiance, pdf;
};

void evaluate_emitter(const Emitter& emitter, const SurfaceBlock& points, const Columns3& from,
                      std::span<const uint32_t> rows, size_t first, Columns& memory, Emitted& out) {
  if (!emitter.is_surface() && !emitter.is_environment()) return;
  const Columns3 radiance = memory.three();
  float* const pdf = memory.one();
  if (emitter.is_surface()) {
    emitter.eval_surface_block(points, from, radiance, pdf);
  } else {
    for (size_t i = 0; i < rows.size(); ++i) {
      points.wi.set(i, -glm::normalize(points.wi.at(i)));
    }
    emitter.eval_environment_block(points.wi, rows.size(), radiance, pdf);
  }
  for (size_t i = 0; i < rows.size(); ++i) {
    set_row3(out.radiance, first + rows[i], radiance.at(i));
    out.pdf[first + rows[i]] = pdf[i];
  }
}

/// Point from which a ray leaves, with the fields that its offset needs.
SurfaceInteraction origin_at(const Floats& p, const Floats& n, const Floats& p_error, size_t i) {
  SurfaceInteraction si;
  si.p = row3(p.data(), i), si.n = row3(n.data(), i), si.p_error = p_error.data()[i];
  return si;
}

}  // namespace

nb::tuple intersect_rays(const SceneEditor& editor, Floats rays, bool is_coherent) {
  const auto scene = editor.scene();
  const auto coherence = is_coherent ? Coherence::kCoherent : Coherence::kIncoherent;
  Found found(rays.shape(0));
  for_each_block(rays.shape(0), [&](size_t first, size_t count) {
    intersect_block(*scene, rays.data(), first, count, coherence, found);
  });
  const auto take = [&](size_t k) { return array_of(std::move(found.triples[k])); };
  return nb::make_tuple(HeldScene{scene}, array_of(std::move(found.t)), take(0), take(1), take(2),
                        take(3), take(4), take(5), take(6), take(7), array_of(std::move(found.uv)),
                        array_of(std::move(found.p_error)), array_of(std::move(found.primitive)),
                        array_of(std::move(found.shape)));
}

nb::object occlude_rays(const SceneEditor& editor, Floats rays, bool is_coherent) {
  const auto scene = editor.scene();
  std::vector<uint32_t> is_occluded(rays.shape(0));
  for_each_block(rays.shape(0), [&](size_t first, size_t count) {
    std::vector<Ray16> block(padded(count) / kBlockLanes);
    read_rays(rays.data(), first, count, block);
    const auto tmax_of = [&](size_t i) { return block[i / kBlockLanes].tmax[i % kBlockLanes]; };
    // Occluded rays get a tmax of minus infinity, which rays may also have from the start.
    std::vector<uint8_t> is_possible(count);
    for (size_t i = 0; i < count; ++i) is_possible[i] = tmax_of(i) >= 0;
    RenderCounters counters;
    scene->occluded(block.data(), block.size(),
                    is_coherent ? Coherence::kCoherent : Coherence::kIncoherent, counters);
    for (size_t i = 0; i < count; ++i) {
      is_occluded[first + i] = is_possible[i] && tmax_of(i) == -kInfinity;
    }
  });
  return array_of(std::move(is_occluded));
}

nb::object sample_rays(const SceneEditor& editor, const std::string& path, Floats positions,
                       Floats aperture) {
  const auto* const sensor = dynamic_cast<const Sensor*>(object_at(editor, path));
  if (!sensor) throw Error("'" + path + "' is not a sensor");
  const Rect crop = sensor->film().crop();
  std::vector<float> rays(8 * positions.shape(0));
  for_each_block(positions.shape(0), [&](size_t first, size_t count) {
    Columns memory(count);
    const Columns2 film = memory.two(), lens = memory.two();
    for (size_t i = 0; i < count; ++i) {
      const float* const u = positions.data() + 2 * (first + i);
      film.set(i, {static_cast<float>(crop.x0) + u[0] * static_cast<float>(crop.width()),
                   static_cast<float>(crop.y0) + u[1] * static_cast<float>(crop.height())});
      lens.set(i, {aperture.data()[2 * (first + i)], aperture.data()[2 * (first + i) + 1]});
    }
    std::vector<RayHit16> block(padded(count) / kBlockLanes);
    sensor->sample_ray_block(film, lens, count, block.data());
    for (size_t i = 0; i < count; ++i) {
      write_ray(rays, first + i, ray_of(&block[i / kBlockLanes].ray, i % kBlockLanes));
    }
  });
  return array_of(std::move(rays));
}

nb::tuple shade_points(const SceneEditor& editor, const std::string& path, nb::tuple arrays,
                       nb::object wo, nb::object u1, nb::object u2, uint32_t lobes) {
  const PointArrays points(arrays);
  const Bsdf* const given = object_for<Bsdf>(editor, path, points);
  const ShadeQuery query{data_or_null(wo), data_or_null(u1), data_or_null(u2),
                         static_cast<Lobe>(lobes)};
  Shaded out(points.count);
  for_each_block(points.count, [&](size_t first, size_t count) {
    const auto bsdf_of = [&](size_t i) -> const Bsdf* {
      const Shape* const shape = points.shape_of(first + i);
      return given || !shape ? given : &shape->bsdf();
    };
    for_each_group(count, bsdf_of, [&](const Bsdf& bsdf, std::span<const uint32_t> rows) {
      Columns memory(rows.size());
      shade_group(bsdf, points.gather(first, rows, memory), rows, first, query, memory, out);
    });
  });
  return nb::make_tuple(array_of(std::move(out.f)), array_of(std::move(out.pdf)),
                        array_of(std::move(out.wo)), array_of(std::move(out.weight)),
                        array_of(std::move(out.sample_pdf)), array_of(std::move(out.is_delta)),
                        array_of(std::move(out.eta)));
}

nb::object albedo_of_points(const SceneEditor& editor, const std::string& path, nb::tuple arrays) {
  const PointArrays points(arrays);
  const Bsdf* const given = object_for<Bsdf>(editor, path, points);
  std::vector<float> albedo(3 * points.count);
  for_each_block(points.count, [&](size_t first, size_t count) {
    std::vector<uint32_t> rows(count);
    std::iota(rows.begin(), rows.end(), 0u);
    Columns memory(count);
    const SurfaceBlock block = points.gather(first, rows, memory);
    for (size_t i = 0; i < count; ++i) {
      const Bsdf* const bsdf = given || !block.shape[i] ? given : &block.shape[i]->bsdf();
      if (bsdf) set_row3(albedo, first + i, bsdf->albedo(interaction_of(block, i)));
    }
  });
  return array_of(std::move(albedo));
}

nb::tuple emission_of_points(const SceneEditor& editor, const std::string& path, nb::tuple arrays,
                             Floats from) {
  const PointArrays points(arrays);
  const Emitter* const given = object_for<Emitter>(editor, path, points);
  const auto scene = editor.scene();
  Emitted out(points.count);
  for_each_block(points.count, [&](size_t first, size_t count) {
    const auto emitter_of = [&](size_t i) {
      const Shape* const shape = points.shape_of(first + i);
      return given ? given : shape ? shape->emitter() : scene->environment();
    };
    for_each_group(count, emitter_of, [&](const Emitter& emitter, std::span<const uint32_t> rows) {
      Columns memory(rows.size());
      const SurfaceBlock block = points.gather(first, rows, memory);
      const Columns3 seen_from = memory.three();
      for (size_t i = 0; i < rows.size(); ++i) {
        seen_from.set(i, row3(from.data(), first + rows[i]));
      }
      evaluate_emitter(emitter, block, seen_from, rows, first, memory, out);
    });
  });
  return nb::make_tuple(array_of(std::move(out.radiance)), array_of(std::move(out.pdf)));
}

nb::tuple sample_emitters(const SceneEditor& editor, Indices emitters, Floats p, Floats u) {
  const auto scene = editor.scene();
  const size_t rows_in_all = emitters.size();
  std::vector<float> d(3 * rows_in_all), distance(rows_in_all), pdf(rows_in_all),
      radiance(3 * rows_in_all), is_delta(rows_in_all);
  for_each_block(rows_in_all, [&](size_t first, size_t count) {
    const auto emitter_of = [&](size_t i) -> const Emitter* {
      const uint32_t index = emitters.data()[first + i];
      return index < scene->emitters().size() ? scene->emitters()[index] : nullptr;
    };
    for_each_group(count, emitter_of, [&](const Emitter& emitter, std::span<const uint32_t> rows) {
      Columns memory(rows.size());
      const Columns3 from = memory.three();
      const Columns2 random = memory.two();
      for (size_t i = 0; i < rows.size(); ++i) {
        const size_t row = first + rows[i];
        from.set(i, row3(p.data(), row));
        random.set(i, {u.data()[2 * row], u.data()[2 * row + 1]});
      }
      const DirectBlock found{memory.three(), memory.one(), memory.one(), memory.three(),
                              memory.one()};
      emitter.sample_direct_block(from, random, rows.size(), found);
      for (size_t i = 0; i < rows.size(); ++i) {
        const size_t row = first + rows[i];
        if (!(found.pdf[i] > 0)) continue;
        set_row3(d, row, found.d.at(i)), set_row3(radiance, row, found.radiance.at(i));
        distance[row] = found.distance[i], pdf[row] = found.pdf[i];
        is_delta[row] = found.is_delta[i];
      }
    });
  });
  return nb::make_tuple(array_of(std::move(d)), array_of(std::move(distance)),
                        array_of(std::move(pdf)), array_of(std::move(radiance)),
                        array_of(std::move(is_delta)));
}

nb::object spawn_origins(Floats p, Floats n, Floats p_error, Floats d) {
  std::vector<float> origins(3 * p.shape(0));
  for (size_t i = 0; i < p.shape(0); ++i) {
    set_row3(origins, i, origin_at(p, n, p_error, i).ray_origin(row3(d.data(), i)));
  }
  return array_of(std::move(origins));
}

nb::object shadow_rays(Floats p, Floats n, Floats p_error, Floats to) {
  std::vector<float> rays(8 * p.shape(0));
  for (size_t i = 0; i < p.shape(0); ++i) {
    write_ray(rays, i, origin_at(p, n, p_error, i).shadow_ray_to(row3(to.data(), i)));
  }
  return array_of(std::move(rays));
}

}  // namespace kinome::python
