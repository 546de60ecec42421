"""Measures the bias of Mitsuba's Beckmann lobes with sampling of visible normals, the default: see
README.md.

    v/bin/python validation/references/check_visible_normals.py

A specular surface is below a uniform sky of radiance 1. Its radiance is computed from Mitsuba's own BSDF by
quadrature, without random numbers. The `direct` integrator should give the same value with every sampling
method. Takes half a minute. Needs mitsuba 3.9.1 and Debian's libllvm19.
"""
import sys

import environment

if not environment.use_llvm():
    sys.exit("check_visible_normals.py: libLLVM 19 not found: apt-get install libllvm19")
import mitsuba as mi  # noqa: E402
import numpy as np  # noqa: E402

mi.set_variant("llvm_ad_rgb")
SCENE = """<scene version="3.0.0">
<integrator type="direct">
  <integer name="bsdf_samples" value="1"/><integer name="emitter_samples" value="0"/>
</integrator>
<sensor type="orthographic">
  <transform name="to_world">
    <scale value="0.01"/><lookat origin="0, {z}, {x}" target="0, 0, 0" up="1, 0, 0"/>
  </transform>
  <sampler type="independent"><integer name="sample_count" value="4096"/></sampler>
  <film type="hdrfilm">
    <integer name="width" value="32"/><integer name="height" value="32"/><rfilter type="box"/>
    <string name="pixel_format" value="rgb"/>
  </film>
</sensor>
<emitter type="constant"/>
<shape type="rectangle">
  <transform name="to_world"><rotate x="1" angle="-90"/></transform>
  <bsdf type="roughplastic">
    <string name="distribution" value="{distribution}"/>
    <boolean name="sample_visible" value="{visible}"/>
    <rgb name="diffuse_reflectance" value="0"/>
  </bsdf>
</shape>
</scene>"""
COSINES = (0.07, 0.1, 0.15, 0.25, 0.5)


def quadrature(distribution, cosine, steps=2000):
    """Returns the integral of f cos over the hemisphere by the midpoint rule. The points are denser near the
    mirror direction."""
    bsdf = mi.load_dict({"type": "roughplastic", "distribution": distribution,
                         "diffuse_reflectance": {"type": "rgb", "value": 0.0}})
    interaction = mi.SurfaceInteraction3f()
    interaction.wi = mi.Vector3f(float(np.sqrt(1 - cosine ** 2)), 0, float(cosine))
    u = (np.arange(2 * steps) + 0.5) / (2 * steps)
    azimuth, width = np.pi * u ** 3, 3 * np.pi * u ** 2 / (2 * steps)
    total = 0.0
    for z in np.array_split((np.arange(steps) + 0.5) / steps, 10):
        z = z[:, None]
        r = np.sqrt(1 - z ** 2)
        wo = mi.Vector3f(*(mi.Float(np.broadcast_to(v, (len(z), 2 * steps)).ravel())
                           for v in (-r * np.cos(azimuth), r * np.sin(azimuth), z)))
        f = np.array(bsdf.eval(mi.BSDFContext(), interaction, wo))[0]
        total += 2 * (f.reshape(len(z), -1).astype(float) * width).sum() / steps
    return total


def rendered(distribution, visible, cosine):
    """Returns the mean of the image, and its standard error."""
    text = SCENE.format(distribution=distribution, visible=str(visible).lower(), z=2 * cosine,
                        x=2 * np.sqrt(1 - cosine ** 2))
    pixels = np.array(mi.render(mi.load_string(text), seed=1)).mean(2)
    return pixels.mean(), pixels.std() / np.sqrt(pixels.size)


def main():
    print("| lobe, sampled by | cosine | by quadrature | by `direct` | too bright by |")
    print("|---|---|---|---|---|")
    for distribution, visible in (("beckmann", True), ("beckmann", False), ("ggx", True)):
        for cosine in COSINES:
            exact = quadrature(distribution, cosine)
            mean, error = rendered(distribution, visible, cosine)
            print(f"| {distribution}, {'visible' if visible else 'all'} normals | {cosine:g} | "
                  f"{exact:.5f} | {mean:.5f} ± {error:.5f} | {100 * (mean / exact - 1):+.2f} % |",
                  flush=True)


if __name__ == "__main__":
    main()
