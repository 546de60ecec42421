"""The plugins of wrong_*.cpp: what is wrong with each, and what `kinome check` must say of it."""
import pathlib
import re

FOLDER = pathlib.Path(__file__).resolve().parent

# By category, for each value of the parameter `fault`: what is wrong, the check that must say so, and a
# part of what it says, or several of which it says one, with | between them.
WRONG_PLUGINS = {
    "emitter": [
        ("scale of 0", "`scale` = 0 is taken, and divided by itself: the radiance is NaN",
         "parameters", "scale = \"0\" is taken, but then"),
        ("exception", "a negative `scale` is refused by an exception of the standard library",
         "parameters", "an exception that is no kinome::Error"),
        ("no message", "a negative `scale` is refused without a word",
         "parameters", "an error without a message"),
        ("negative", "the radiance is below 0 in a small part of the sky",
         "values", "radiance is negative"),
        ("length", "directions that `sample_direct` returns are 1 % too long",
         "values", "not of unit length"),
        ("twice the density", "`sample_direct` returns twice the density",
         "density", "sample_direct() returns densities 2 times those of"),
        ("half density", "both `sample_direct` and `pdf_environment` tell half the density",
         "sampling", "it is 0.5 times what it must be"),
        ("one side", "half of the sky is never sampled, but has a density",
         "sampling", "samples don't follow pdf_environment()"),
        ("other radiance", "`sample_direct` returns 5 % more radiance than `eval_environment`",
         "consistency", "a radiance from sample_direct() that is not"),
        ("batch", "`eval_environment_batch` returns 5 % more radiance than `eval_environment`",
         "blocks", "eval_environment_batch() from eval_environment()"),
        ("grid", "the radiance has a step, and `cell_grid` says that it is bilinear",
         "cell_grid", "quads are not bilinear as it says"),
        ("emission", "`sample_emission` sends out 10 % too much light",
         "emission", "sample_emission() sends out 1.1 times"),
        ("emission direction", "`sample_emission` sends light upwards only",
         "emission_density", "emission_density()"),
        ("emission density", "`emission_density` tells twice the density of a direction",
         "emission_density", "it is 2 times what it must be"),
        ("extent", "the light points have no extent",
         "light_points", "an extent that is not positive"),
    ],
    "bsdf": [
        ("twice the density", "`sample` returns twice the density",
         "density", "sample() returns densities 2 times those of eval_pdf()"),
        ("weight", "`sample` returns weights that are 10 % too great",
         "density", "sample() returns weights 1.1 times"),
        ("half density", "both `sample` and `eval_pdf` tell half the density",
         "sampling", "it is 0.5 times what it must be"),
        ("uniform", "directions are sampled evenly, but their density is that of cosine sampling",
         "sampling", "samples don't follow eval_pdf()"),
        ("viewer", "it is darker for a viewer at a grazing angle, but not for light from there",
         "reciprocity", "f(wi, wo) isn't f(wo, wi)"),
        ("too bright", "it reflects 1.2 times the light that arrives",
         "energy", "more light leaves than arrives: 1.2 times"),
        ("through", "samples leave at the back of a surface that lets no light through",
         "values", "which transmits_ denies"),
        ("lobe", "samples are said to be of a glossy lobe, and it has only a diffuse one",
         "values", "a lobe that is not in lobes_"),
        ("reflectance", "`reflectance` says that it has no diffuse part",
         "reflectance", "there is no diffuse part"),
        ("block", "`shade_block` is 10 % brighter than `eval_pdf`",
         "blocks", "shade_block() has other values than eval_pdf()"),
        # Sanitizers end the process by themselves.
        ("crash", "it crashes on light at a grazing angle",
         "values", "a crash (Segmentation fault)|the program ended"),
    ],
    "shape": [
        ("elsewhere", "a hit's point is 0.01 above the surface",
         "interactions", "a p that is not where the ray ends"),
        ("normal", "normals are 10 % too long",
         "interactions", "a normal n that is not of unit length"),
        ("wi", "`wi` points along the ray, not back to where it came from",
         "interactions", "a wi that is not where the ray came from"),
        ("length", "distances are in units of length, not of the ray's direction",
         "segments", "another t for a direction of twice the length"),
        ("area", "`area` is 25 % too great",
         "area", "area() is 1.25"),
        ("quarter", "only a quarter of the surface is sampled",
         "area", "sample_surface() is not uniform"),
        ("beyond", "points are sampled beyond the edges",
         "points", "bounds() leaves out"),
        ("density", "`pdf_solid_angle` is 20 % too great",
         "solid_angle", "it is 1.2 times what it must be"),
        ("block", "`sample_solid_angle_block` tells densities 10 % above those of single points",
         "sample_blocks", "sample_solid_angle_block() differs"),
    ],
    "texture": [
        ("mean", "`mean` is 0.6, and should be 0.5",
         "mean", "mean() is (0.6, 0.6, 0.6), that of eval() (0.5"),
        ("max", "`max` is 0.7, and values go up to 1",
         "values", "max()"),
        ("uniform", "`is_uniform` is true of a ramp",
         "values", "is_uniform() is true of what isn't"),
        ("block", "`eval_block` has 10 % less green than `eval`",
         "blocks", "eval_block() differs from eval()"),
    ],
    "sampler": [
        ("one", "1 of 100 numbers is 1, and must be below",
         "values", "outside of [0, 1)"),
        ("uneven", "numbers are squared, which makes small ones more frequent",
         "uniform", "value_1d(0) is not uniform"),
        ("same dimensions", "all dimensions have the same numbers",
         "independent", "samples of different dimensions are correlated"),
        ("same pixels", "pixels in pairs have the same numbers",
         "independent", "samples of different pixels are correlated"),
        ("block", "`fill_1d_block` fills in the next dimension's numbers",
         "blocks", "fill_1d_block()"),
    ],
    "rfilter": [
        ("radius", "the filter reaches as far as 1, and its `radius` is 0.8",
         "values", "beyond the radius"),
        ("one side", "it is 10 % lower on the left",
         "values", "it is to be symmetric"),
        ("block", "`eval_block` is 1 % greater than `eval`",
         "values", "eval_block()"),
    ],
}


def planted():
    """{category: the faults that its source has}."""
    return {path.stem.removeprefix("wrong_"):
            set(re.findall(r"\b(?:is|or_wrong)\(\"([^\"]+)\"", path.read_text("utf-8")))
            for path in FOLDER.glob("wrong_*.cpp")}
