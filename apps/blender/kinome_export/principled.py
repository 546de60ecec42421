"""Maps Blender's Principled BSDF to Mitsuba's `principled`. docs/blender.md has the measurements."""
import math

from . import elements as e, energy
from .textures import as_color, as_number, is_link, fold


def reflectance_of_ior(ior):
    """Fresnel reflectance at normal incidence."""
    return ((ior - 1) / (ior + 1)) ** 2


def eta_of(ior, level):
    """Index of refraction with the reflectance of Blender's IOR and Specular IOR Level. The level
    scales the reflectance at normal incidence; 0.5 leaves it as it is."""
    root = math.sqrt(min(reflectance_of_ior(ior) * 2 * level, 0.98))
    return (1 + root) / (1 - root)


def clearcoat_of(weight, roughness, ior):
    """Mitsuba's clearcoat and clearcoat_gloss. The coat has the same albedo as Cycles', and half of
    its normals are as close to that of the surface: within atan(alpha) for GGX, atan(sqrt(alpha)) for
    Mitsuba's GTR, whose alpha is between 0.1 and 0.001."""
    gloss = min(max((0.1 - roughness**4) / 0.099, 0), 1)
    return weight * _coat_albedo(roughness, ior) / energy.clearcoat(gloss), gloss


def _coat_albedo(roughness, ior):
    return energy.specular(max(roughness**2, 1e-3), ior)


def base_color_of(color, roughness, eta, metallic=0.0, coat=0.0):
    """Mitsuba's base_color with the same albedo under a white sky as Cycles' base colour. `coat`
    is the albedo of the coat above."""
    alpha = max(roughness**2, 1e-3)
    (white, single, schlick), full = energy.ggx(alpha, eta), energy.specular(alpha, eta)
    result = []
    for c in color:
        plastic = (c * (1 - full) + full - single) / energy.diffuse(roughness)
        wanted = energy.with_multiple_scattering(c + (1 - c) * schlick, white, (20 * c + 1) / 21)
        metal = min((wanted - schlick) / (1 - schlick), 1)
        result.append(min(max(((1 - metallic) * plastic + metallic * metal) * (1 - coat), 0), 1))
    return result


# Albedo of Cycles' sheen with the weight 1 and the roughness 0.5, measured in a white furnace.
_SHEEN_ALBEDO = 0.09
# Least roughness of plastics that become Lambertian.
_MATTE_ROUGHNESS = 0.8


_IGNORED = (  # label, value without effect
    ("Subsurface Weight", 0), ("Thin Film Thickness", 0), ("Diffuse Roughness", 0), ("Anisotropic Rotation", 0))


def check(values, inputs):
    """Warns of inputs that Mitsuba's BSDF doesn't have."""
    for label, neutral in _IGNORED:
        value = fold(values.get(label, neutral))
        if is_link(value) or as_number(value) != neutral:
            inputs.report.warn(inputs.owner, f"'{label}' is left out")
    for label, result in (("Specular Tint", "reflections are white"), ("Coat Tint", "the coat is colourless")):
        tint = fold(values.get(label, [1, 1, 1]))
        if is_link(tint) or any(abs(c - 1) > 1e-3 for c in as_color(tint)):
            inputs.report.warn(inputs.owner, f"'{label}' is left out; {result}")


def opaque(values, inputs):
    """Returns a BSDF without transmission; or two of them, and the weight of the second."""
    weight, metallic = fold(values["Coat Weight"]), fold(values["Metallic"])
    has_coat = not is_link(weight) and as_number(weight) > 0
    if not has_coat or is_link(metallic) or as_number(metallic) > 0:
        return _opaque(values, inputs)
    # The specular lobe becomes the coat, which Mitsuba's clearcoat with its wide tails resembles less. What
    # the base itself reflects is broad, and joins the diffuse lobe.
    color = fold(values["Base Color"])
    if not is_link(color):
        ior, level, roughness = (_number(values[label]) for label in ("IOR", "Specular IOR Level", "Roughness"))
        specular = energy.specular(max(roughness**2, 1e-3), eta_of(ior, level))
        color = [specular + (1 - specular) * c for c in as_color(color)]
    coated = {**values, "Base Color": color, "Coat Weight": 0.0, "Specular IOR Level": 0.5,
              "Roughness": values["Coat Roughness"], "IOR": values["Coat IOR"]}
    if as_number(weight) >= 1:
        return _opaque(coated, inputs)
    return [_opaque({**values, "Coat Weight": 0.0}, inputs), _opaque(coated, inputs), as_number(weight)]


def _is_matte(values):
    """Returns true for plastics that are so rough that a Lambertian surface resembles Cycles' more: the
    diffuse lobe of `principled` is brighter at grazing angles, by 40 % with the roughness 1."""
    roughness, metallic = fold(values["Roughness"]), fold(values["Metallic"])
    return not is_link(roughness) and not is_link(metallic) and as_number(metallic) == 0 and \
        as_number(roughness) >= _MATTE_ROUGHNESS and not _is_set(values["Coat Weight"])


def _matte(values, inputs):
    color = fold(values["Base Color"])
    if not is_link(color):
        ior, level, roughness = (_number(values[label]) for label in ("IOR", "Specular IOR Level", "Roughness"))
        specular = energy.specular(roughness**2, eta_of(ior, level))
        color = _with_sheen([specular + (1 - specular) * c for c in as_color(color)], values, inputs)
    return e.plugin("bsdf", "diffuse", inputs.color("reflectance", color))


def _opaque(values, inputs):
    if _is_matte(values):
        return _matte(values, inputs)
    ior = as_number(inputs.constant("IOR", values["IOR"]))
    eta = eta_of(ior, as_number(inputs.constant("Specular IOR Level", values["Specular IOR Level"])))
    children = [inputs.color("base_color", _base_color(values, eta, inputs)), inputs.number("metallic", values["Metallic"]),
                inputs.number("roughness", values["Roughness"]), e.floating("eta", eta)]
    if _is_set(values["Anisotropic"]):
        children.append(inputs.number("anisotropic", values["Anisotropic"]))
    if _is_set(values["Sheen Weight"]) and is_link(fold(values["Base Color"])):
        children.append(inputs.number("sheen", values["Sheen Weight"]))
    return e.plugin("bsdf", "principled", *children, *_coat(values, inputs))


def glass(values, inputs):
    """Returns `principled` with full transmission."""
    ior = as_number(inputs.constant("IOR", values["IOR"]))
    return e.plugin("bsdf", "principled", inputs.color("base_color", values["Base Color"]),
                    inputs.number("roughness", values["Roughness"]), e.floating("eta", ior),
                    e.floating("spec_trans", 1), *_coat(values, inputs))


def share_of_glass(values, inputs):
    """Returns the weight of the glass, a number or a link, and the inputs of the rest."""
    transmission, metallic = fold(values["Transmission Weight"]), fold(values["Metallic"])
    if is_link(transmission) or as_number(transmission) == 0:
        return transmission, values
    metallic = as_number(inputs.constant("Metallic", metallic))
    share = as_number(transmission) * (1 - metallic)
    return share, {**values, "Metallic": metallic / (1 - share) if share < 1 else 0.0}


def _base_color(values, eta, inputs):
    """Returns the base colour, adapted to Mitsuba's lobes unless it is a texture."""
    color = fold(values["Base Color"])
    if is_link(color):
        return color
    roughness, metallic, weight, coat_roughness, coat_ior = (_number(values[label]) for label in (
        "Roughness", "Metallic", "Coat Weight", "Coat Roughness", "Coat IOR"))
    coat = weight * _coat_albedo(coat_roughness, coat_ior) if weight > 0 else 0
    return _with_sheen(base_color_of(as_color(color), roughness, eta, metallic, coat), values, inputs)


def _with_sheen(color, values, inputs):
    """Adds Cycles' sheen, which is broad, to a diffuse colour."""
    share = _SHEEN_ALBEDO * _number(values["Sheen Weight"])
    tint = as_color(inputs.constant("Sheen Tint", values["Sheen Tint"])) if share > 0 else color
    return [c * (1 - share) + share * t for c, t in zip(color, tint)]


def _number(value):
    """Returns a number. Textures count as their unconnected values."""
    value = fold(value)
    return as_number(value["default"] if is_link(value) else value)


def _is_set(value):
    value = fold(value)
    return is_link(value) or as_number(value) != 0


def _coat(values, inputs):
    if not _is_set(values["Coat Weight"]):
        return []
    ior = as_number(inputs.constant("Coat IOR", values["Coat IOR"]))
    weight = as_number(inputs.constant("Coat Weight", values["Coat Weight"]))
    roughness = as_number(inputs.constant("Coat Roughness", values["Coat Roughness"]))
    clearcoat, gloss = clearcoat_of(weight, roughness, ior)
    return [e.floating("clearcoat", clearcoat), e.floating("clearcoat_gloss", gloss)]
