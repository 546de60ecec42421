"""Albedos of lobes, averaged over the views of a sphere (cosine-weighted), by quadrature.

Mitsuba's `principled` adds its lobes. Cycles' Principled BSDF layers them: what a coat or the specular
reflection takes is missing below, and rough lobes get the energy that light loses between microfacets.
"""
import functools

import numpy as np

_COUNT = 24  # points of the quadrature in each dimension


def _midpoints():
    at = (np.arange(_COUNT) + 0.5) / _COUNT
    return np.meshgrid(np.sqrt(at), at, at, indexing="ij")  # cosine of the view, two sample coordinates


def fresnel(cosine, eta):
    """Reflectance of a dielectric from outside."""
    g = np.sqrt(eta**2 - 1 + cosine**2)
    a = ((g - cosine) / (g + cosine)) ** 2
    return 0.5 * a * (1 + ((cosine * (g + cosine) - 1) / (cosine * (g - cosine) + 1)) ** 2)


def smith_g1(cosine, alpha):
    return 2 / (1 + np.sqrt(1 + alpha**2 * (1 / cosine**2 - 1)))


def with_multiple_scattering(albedo, white, mean):
    """Adds the energy that Cycles gives to a lobe for scattering between microfacets (Kulla and Conty 2017,
    "Revisiting Physically Based Shading at Imageworks"). `white` is the lobe's albedo if the microfacets
    reflect everything, `mean` is their mean reflectance."""
    again = mean * white / (1 - mean * (1 - white))
    return albedo * (1 + (1 / white - 1) * again)


@functools.lru_cache(maxsize=None)
def ggx(alpha, eta):
    """Returns the albedo of GGX if the microfacets reflect everything, that of a dielectric, and the mean
    of Schlick's weight (1 - cosine)^5."""
    mu, u, v = _midpoints()
    # Visible normals (Heitz and Dupuy 2023, "Sampling Visible GGX Normals with Spherical Caps").
    length = np.sqrt(alpha**2 * (1 - mu**2) + mu**2)
    wx, wz = alpha * np.sqrt(1 - mu**2) / length, mu / length
    z = (1 - u) * (1 + wz) - wz
    r, phi = np.sqrt(1 - z**2), 2 * np.pi * v
    m = np.array([alpha * (r * np.cos(phi) + wx), alpha * r * np.sin(phi), z + wz])
    m /= np.linalg.norm(m, axis=0)
    cos_d = np.sqrt(1 - mu**2) * m[0] + mu * m[2]
    cos_o = 2 * cos_d * m[2] - mu
    weight = np.where(cos_o > 0, smith_g1(np.maximum(cos_o, 1e-6), alpha), 0)
    white = weight.mean(axis=(1, 2))
    dielectric = (weight * fresnel(np.clip(cos_d, 0, 1), max(eta, 1 + 1e-6))).mean(axis=(1, 2))
    schlick = (weight * (1 - np.clip(cos_d, 0, 1)) ** 5).mean() / white.mean()
    return float(white.mean()), float(dielectric.mean()), float(schlick)


def specular(alpha, eta):
    """Returns the albedo of Cycles' specular reflection of a dielectric."""
    white, single, _ = ggx(alpha, eta)
    return with_multiple_scattering(single, white, ggx(1e-3, eta)[1])


@functools.lru_cache(maxsize=None)
def diffuse(roughness):
    """Returns the albedo of Mitsuba's diffuse base with the base colour 1 (Burley 2012)."""
    mu, u, v = _midpoints()
    cos_o = np.sqrt(u)
    cos_d2 = 0.5 * (1 + mu * cos_o + np.sqrt((1 - mu**2) * (1 - u)) * np.cos(2 * np.pi * v))
    i, o, rr = (1 - mu) ** 5, (1 - cos_o) ** 5, 2 * roughness * cos_d2
    return float(np.mean((1 - 0.5 * i) * (1 - 0.5 * o) + rr * (i + o + i * o * (rr - 1))))


@functools.lru_cache(maxsize=None)
def clearcoat(gloss):
    """Returns the albedo of Mitsuba's clear coat of strength 1: GTR with exponent 1."""
    alpha2 = (0.1 + (0.001 - 0.1) * gloss) ** 2
    mu, u, v = _midpoints()
    cos_h = np.sqrt((1 - alpha2**u) / (1 - alpha2))
    sin_h = np.sqrt(1 - cos_h**2)
    cos_d = np.sqrt(1 - mu**2) * sin_h * np.cos(2 * np.pi * v) + mu * cos_h
    cos_o = 2 * cos_d * cos_h - mu
    schlick = 0.04 + 0.96 * (1 - np.clip(cos_d, 0, 1)) ** 5
    g = smith_g1(mu, 0.25) * smith_g1(np.maximum(cos_o, 1e-6), 0.25)
    return float(np.mean(np.where((cos_o > 0) & (cos_d > 0), cos_o * g * schlick * cos_d / cos_h, 0)))
