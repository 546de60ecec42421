"""Tests of the comparison on images with known noise: it passes correct renders at its stated rate,
and fails those with a small defect."""

import pathlib
import sys
import unittest
import unittest.mock

import numpy as np
from scipy import stats

ROOT = pathlib.Path(__file__).resolve().parents[4]
sys.path[:0] = [str(ROOT / "validation"), str(ROOT / "tests/support")]
from compare import BadInput, Errors, Estimate, compare  # noqa: E402
from simulated_film import render  # noqa: E402
from simulated_renders import (HEIGHT, RENDERS, WIDTH, X, Y, estimate, noisy,  # noqa: E402
                               picture, rare)


class FalseAlarms(unittest.TestCase):
    """Failures are tested against the binomial distribution at a false-alarm rate of 1e-4."""

    def test_200_correct_comparisons_fail_at_the_stated_rate(self):
        rng = np.random.default_rng(20)
        alphas, failures, p = (0.01, 0.1), [0, 0], []
        for i in range(200):
            kind = ("gamma", "firefly", "gamma", "lognormal", "gamma")[i % 5]
            a = estimate(rng, picture(), 8, kind)
            b = estimate(rng, picture(), 32, kind, stored=True)
            for j, alpha in enumerate(alphas):
                verdict = compare(a, b, alpha)
                failures[j] += not verdict.passed
            p.append(verdict.tests[0].p)
        for alpha, count in zip(alphas, failures):
            self.assertLessEqual(count, stats.binom.ppf(1 - 1e-4, 200, alpha), alpha)
        # The image's test has exactly its stated rate, not only as an upper bound.
        low, high = stats.binom.ppf([0.5e-4, 1 - 0.5e-4], 200, 0.2)
        self.assertGreaterEqual((np.array(p) < 0.2).sum(), low)
        self.assertLessEqual((np.array(p) < 0.2).sum(), high)

    def test_fewer_renders_keep_the_rate(self):
        rng = np.random.default_rng(21)
        failures = sum(not compare(estimate(rng, picture(), 8, "gamma", renders=6),
                                   estimate(rng, picture(), 32, "gamma", stored=True), 0.02).passed
                       for _ in range(40))
        self.assertLessEqual(failures, stats.binom.ppf(1 - 1e-4, 40, 0.02))

    def test_correlated_pixels_are_noticed_and_keep_the_rate(self):
        rng = np.random.default_rng(3)

        def blurred():
            # Noise like that of a 3x3 reconstruction filter, and light that all pixels share.
            noise = rng.standard_normal((HEIGHT + 2, WIDTH + 2))
            noise = sum(noise[i:i + HEIGHT, j:j + WIDTH] for i in range(3) for j in range(3))
            return (picture() * (1 + 0.05 * noise + 0.02 * rng.standard_normal()))[:, :, None]

        failures = 0
        for _ in range(40):
            a, b = (Estimate.from_renders(n, [blurred() for _ in range(RENDERS)]) for n in "ab")
            verdict = compare(a, b, 0.05)
            failures += not verdict.passed
            self.assertIn("pixels share noise", " ".join(verdict.notes))
        self.assertLessEqual(failures, stats.binom.ppf(1 - 1e-4, 40, 0.05))

    def test_a_filter_of_any_width_keeps_the_rate(self):
        # Gaussian: without the variance of tiles, a third of the pairs would fail. 40 pairs suffice
        # to detect that. validation/compare_rates.py makes the full table (200 of every filter).
        for name, pairs in (("gaussian", 40), ("lanczos", 6)):
            rng = np.random.default_rng(5)
            verdicts = [compare(render(rng, name, 2), render(rng, name, 2), 0.01)
                        for _ in range(pairs)]
            failures = sum(not v.passed for v in verdicts)
            self.assertLessEqual(failures, stats.binom.ppf(1 - 1e-4, pairs, 0.01), name)

    def test_masked_pixels_take_their_share_of_a_tile_with_them(self):
        rng, failures = np.random.default_rng(8), 0
        for _ in range(25):
            a, b = (render(rng, "gaussian", 2) for _ in range(2))
            b.masked = rng.random(b.masked.shape) < 0.3
            b.masked[:16, :15] = True
            failures += not compare(a, b, 0.05).passed
        self.assertLessEqual(failures, stats.binom.ppf(1 - 1e-4, 25, 0.05))

    def test_noise_that_lanes_have_in_common_keeps_the_rate(self):
        rng = np.random.default_rng(6)
        failures = sum(not compare(render(rng, "box", 2, common=0.05),
                                   render(rng, "box", 2, common=0.05), 0.05).passed
                       for _ in range(40))
        self.assertLessEqual(failures, stats.binom.ppf(1 - 1e-4, 40, 0.05))

    def test_a_corner_that_few_samples_miss_is_no_failure(self):
        # A pixel is 1 % of another colour: the few samples of A all miss it, the many of B don't.
        exact = np.repeat(picture()[None, :, :, None], 4, axis=0)
        with_corner = exact.copy()
        with_corner[:, 30, 0] *= np.linspace(0.9899, 0.9901, 4)[:, None]
        verdict = compare(Estimate.from_renders("a", exact),
                          Estimate.from_renders("b", with_corner))
        self.assertTrue(verdict.tests[2].passed, verdict.tests[2].worst)
        self.assertIn("6 of 3072 values vary in one image but not in the other",
                      " ".join(verdict.notes))

    def test_without_noise_rounding_passes_and_more_fails(self):
        exact = picture()[:, :, None]
        for factor, passes in ((1, True), (1 + 1e-6, True), (1.0005, False)):
            a = Estimate.from_renders("a", [exact * factor] * 4)
            b = Estimate.from_renders("b", [exact] * 4)
            self.assertEqual(compare(a, b).passed, passes, factor)


def spot(smooth):
    """Returns the image of a spot straight above a floor: cutoff at 40 degrees, full within 30."""
    r2 = ((X - 31.5) / 22) ** 2 + ((Y - 23.5) / 22) ** 2
    theta = np.degrees(np.arctan(np.sqrt(r2)))
    t = np.clip((40 - theta) / 10, 0, 1)
    return 0.01 + (t * t * (3 - 2 * t) if smooth else t) / (1 + r2) ** 2


def texture(shift):
    """Returns the image of a texture of 24x16 texels with bilinear interpolation."""
    texels = np.random.default_rng(1).uniform(0.2, 0.8, (16, 24))
    u, v = (X + 0.5) / WIDTH * 24 - 0.5 + shift, (Y + 0.5) / HEIGHT * 16 - 0.5
    i, j = np.floor(u).astype(int), np.floor(v).astype(int)

    def at(row, column):
        return texels[row % 16, column % 24]

    return ((1 - v + j) * ((1 - u + i) * at(j, i) + (u - i) * at(j, i + 1)) +
            (v - j) * ((1 - u + i) * at(j + 1, i) + (u - i) * at(j + 1, i + 1)))


class Defects(unittest.TestCase):
    """Noise: 2 % to 6 % of a pixel's mean, like that of small references from a few seconds. A
    third of that if `samples` is set."""

    def assert_fails(self, defective, correct, tests=("image", "tiles", "pixels"), samples=400):
        for seed in range(3):
            rng = np.random.default_rng(seed)
            a = estimate(rng, defective, samples, "gamma")
            b = estimate(rng, correct, samples, "gamma", stored=True)
            verdict = compare(a, b)
            self.assertFalse(verdict.passed, [t.worst for t in verdict.tests])
            self.assertTrue(any(not t.passed for t in verdict.tests if t.name in tests))

    def test_radiance_off_by_three_thousandths(self):
        self.assert_fails(picture() * 1.003, picture(), ("image",), samples=4000)

    def test_half_a_texel(self):
        self.assert_fails(texture(0.5), texture(0), ("tiles", "pixels"))

    def test_one_wrong_tile(self):
        wrong = picture()
        wrong[16:32, 32:48] *= 1.03
        self.assert_fails(wrong, picture(), ("tiles",))

    def test_a_single_wrong_pixel(self):
        wrong = picture()
        wrong[30, 50] *= 2
        self.assert_fails(wrong, picture(), ("pixels",))

    def test_a_weak_lobe_is_missing(self):
        gloss = np.exp(-((X - 20) ** 2 + (Y - 30) ** 2) / 60)
        gloss *= 0.008 * picture().sum() / gloss.sum()
        self.assert_fails(picture(), picture() + gloss)

    def test_a_spot_falls_off_smoothly(self):
        self.assert_fails(spot(smooth=True), spot(smooth=False), ("tiles", "pixels"))

    def test_the_size_of_bias_that_is_printed_is_found_nine_times_in_ten(self):
        rng = np.random.default_rng(9)
        b = estimate(rng, picture(), 100, "gamma", stored=True)
        size = compare(estimate(rng, picture(), 100, "gamma"), b).tests[0].detectable
        found = 0
        for _ in range(60):
            b = estimate(rng, picture(), 100, "gamma", stored=True)
            a = estimate(rng, picture() * (1 + size), 100, "gamma")
            found += not compare(a, b).tests[0].passed
        # The size is estimated from a variance with 15 degrees of freedom. It may be 20 % too
        # small, and then the bias is found only 7 times in 10.
        self.assertGreaterEqual(found, stats.binom.ppf(1e-4, 60, 0.7))


class LightThatTheReferenceHardlyFound(unittest.TestCase):
    """The right half of the image, 6 of its 12 tiles, has light that is rare in B: 82 % of its
    values are exactly 0. A finds all of it with little noise, or is wrong."""

    DIM = np.s_[:, WIDTH // 2:]
    SEEDS = 10

    @staticmethod
    def reference(seed, image, hits=0.2):
        """Returns a reference whose right half has rare light, as if read from a file."""
        rng = np.random.default_rng(seed)
        stack = []
        for _ in range(RENDERS):
            made = noisy(rng, image, 400, "gamma")
            dim = LightThatTheReferenceHardlyFound.DIM
            made[dim] = rare(rng, image[dim], hits)
            stack.append(made[:, :, None])
        made = Estimate.from_renders("B", stack)
        made.stack = None
        return made

    @staticmethod
    def dense(seed, image):
        return estimate(np.random.default_rng(1000 + seed), image, 400, "gamma")

    def test_an_image_that_finds_the_light_passes(self):
        failures = 0
        for seed in range(self.SEEDS):
            verdict = compare(self.dense(seed, picture()), self.reference(seed, picture()))
            failures += not verdict.passed
            self.assertEqual((verdict.missed.tiles, verdict.missed.of), (6, 12))
            self.assertEqual(verdict.missed.places[:3], [[32, 0], [48, 0], [32, 16]])
            self.assertTrue(0.7 < verdict.missed.zeros < 0.9, verdict.missed.zeros)
            self.assertTrue(0.3 < verdict.missed.light < 0.8, verdict.missed.light)
        self.assertLessEqual(failures, stats.binom.ppf(1 - 1e-4, self.SEEDS, 0.01))
        with unittest.mock.patch("compare.verdict.hardly_found", lambda a, b, masked: np.zeros(
                (3, 4, 1), bool)):
            blamed = sum(not compare(self.dense(seed, picture()),
                                     self.reference(seed, picture())).passed
                         for seed in range(self.SEEDS))
        self.assertGreater(blamed, 2)  # otherwise the test would be pointless

    def assert_fails(self, a_image, b_image, test="tiles", **options):
        for seed in range(3):
            verdict = compare(self.dense(seed, a_image), self.reference(seed, b_image, **options))
            self.assertFalse(next(t for t in verdict.tests if t.name == test).passed)

    def test_errors_elsewhere_fail(self):
        bright = picture()
        bright[16:32, :16] *= 1.05
        self.assert_fails(bright, picture())
        self.assert_fails(picture() * 1.02, picture(), "image")

    def test_an_image_without_the_light_that_was_found_fails(self):
        dark = picture()
        dark[self.DIM] = 0
        self.assert_fails(dark, picture(), hits=0.8)

    def test_light_where_the_reference_is_black_is_wrong(self):
        black, leak = picture(), picture()
        black[16:] = 0
        leak[17:] = 0  # 1 % of a tile's pixels would suffice: one row of 32 is lit
        self.assert_fails(leak, black)
        # Half of the tile is black, the other half is lit and well sampled.
        black, leak = picture(), picture()
        black[16:32, :8] = 0
        self.assert_fails(leak, black)

    def test_a_black_image_passes_where_the_reference_is_black(self):
        black = picture()
        black[16:] = 0
        self.assertTrue(compare(self.dense(0, black), self.reference(0, black)).passed)

    def test_noise_alone_masks_no_difference(self):
        # 3 or 4 of 16 renders contain most of a value's light, and half of the values are 0 in each
        # render. All are known approximately, so that an error of a third is found.
        rng = np.random.default_rng(4)
        b = Estimate.from_renders("B", [rare(rng, picture(), 8, 1)[:, :, None]
                                        for _ in range(RENDERS)])
        verdict = compare(self.dense(0, picture() * 1.33), b)
        self.assertIsNone(verdict.missed)
        self.assertFalse(verdict.passed)
        # Rare light with similar hits is determined by their number.
        b = Estimate.from_renders("B", [rare(rng, picture() ** 0, 0.4, 0.2)[:, :, None]
                                        for _ in range(RENDERS)])
        self.assertIsNone(compare(self.dense(0, picture() ** 0), b).missed)
        self.assertFalse(compare(self.dense(0, picture() ** 0 * 2), b).passed)

    def test_an_image_that_misses_light_of_the_reference_fails(self):
        b = self.dense(0, picture())
        for seed in range(3):
            verdict = compare(self.reference(seed, picture()), b)
            self.assertIsNone(verdict.missed)
        missing = picture()
        missing[self.DIM] *= 0.5
        for seed in range(3):
            self.assertFalse(compare(self.dense(seed, missing), b).passed)

    def test_a_reference_without_light_is_none(self):
        rng = np.random.default_rng(0)
        b = Estimate.from_renders("B", [rare(rng, picture())[:, :, None] for _ in range(RENDERS)])
        with self.assertRaises(BadInput) as told:
            compare(self.dense(0, picture()), b)
        self.assertIn("hardly found any light", str(told.exception))


class ErrorFigures(unittest.TestCase):
    def test_the_noise_of_the_reference_is_subtracted(self):
        rng = np.random.default_rng(2)
        exact = picture()[:, :, None]
        left, plain = [], []
        for _ in range(10):
            reference = estimate(rng, picture(), 400, "gamma", stored=True)
            left.append(Errors.of(exact, reference, reference.masked).relmse)
            reference.variance[:] = 0
            plain.append(Errors.of(exact, reference, reference.masked).relmse)
        self.assertGreater(np.mean(plain), 20 * abs(np.mean(left)))

    def test_against_the_formula(self):
        reference = Estimate("r", np.array([[[1.0], [3.0]]]), np.array([[[0.01], [0.0]]]), 16)
        errors = Errors.of(np.array([[[2.0], [3.0]]]), reference, reference.masked)
        self.assertAlmostEqual(errors.relmse, (1 - 0.01) / (1 + 0.04) / 2, places=14)
        self.assertAlmostEqual(errors.maximum, (1 - 0.01) / (1 + 0.04), places=14)


if __name__ == "__main__":
    unittest.main()
