"""The errors that docstrings and docs/accuracy.md state, each against a search for a larger one.

The quick search finds most of what the full one (`-m slow`) finds. True values have the 64 bits of extended precision.
"""

import numpy as np
import pytest

import aomc_sky as sky
from aomc_sky.component import MAX_SLOPE
from aomc_sky.directions import given_angle, sin_cos_deg
from aomc_sky.kernels.arithmetic import elementary
from aomc_sky.kernels.cells import laws
from aomc_sky.skies.perez import coefficients
from tests.support.largest_error import HAS_EXTENDED, PI, Extended, Numbers, either_sign, largest_error, ulps, uniform

pytestmark = pytest.mark.skipif(not HAS_EXTENDED, reason="needs an extended precision of 64 bits")

hg, rayleigh, lobes = sky.henyey_greenstein, sky.rayleigh, sky.lobes
BELOW_ONE = 1.0 - 2.0**-53
UNIT = uniform(0.0, 1.0)
CLAIMS = {}


def claim(bound, *numbers, is_valid=lambda *arguments: np.ones(arguments[0].shape, dtype=bool)):
    """Register a function that gives errors of arrays, in units of which `bound` is stated."""

    def register(error):
        CLAIMS[error.__name__] = (error, bound, numbers, is_valid)
        return error

    return register


def extended(*arrays):
    return [array.astype(Extended) for array in arrays]


def quarter_turns(x, unit=1):
    """Sine and cosine of x, of which `unit` are a quarter turn, in extended precision."""
    whole = np.rint(x / unit)
    angle = (x - unit * whole) * (PI / (2 * unit))
    sine, cosine, quarter = np.sin(angle), np.cos(angle), np.mod(whole, 4).astype(int)
    return np.choose(quarter, [sine, cosine, -sine, -cosine]), np.choose(quarter, [cosine, -sine, -cosine, sine])


# ---- Henyey and Greenstein, mirrored so that nothing cancels for g next to -1 ----


def any_g(rng, n):
    """Of all kinds: tiny, and next to 1 and -1."""
    small = either_sign(1e-20, 1.0).draw(rng, n)
    return np.where(rng.random(n) < 0.5, small, uniform(-1.0, 1.0).draw(rng, n))


G = Numbers(-BELOW_ONE, BELOW_ONE, any_g)


def hg_ends(xi, g):
    """1 - mu and 1 + mu."""
    x, g = extended(xi, g)
    h, p, q = np.abs(g), np.where(g >= 0, x, 1 - x), np.where(g >= 0, 1 - x, x)
    square = ((1 - h) + 2 * h * p) ** 2
    near, far = 2 * (1 - h) ** 2 * q * (1 + h * p) / square, 2 * (1 + h) ** 2 * p * ((1 - h) + h * p) / square
    return np.where(g >= 0, near, far), np.where(g >= 0, far, near)


def hg_mu(xi, g):
    minus, plus = hg_ends(xi, g)
    return np.where(minus < 1, 1 - minus, plus - 1)


def is_hg(xi, g):
    return (xi == 0) | (xi > 1e-270)


def hg_parts(v, g):
    """R^2, and the distances from mu = 1 and -1."""
    v, g = extended(v, g)
    h, w = np.abs(g), 2 - v
    return (1 - h) ** 2 + 2 * h * np.where(g >= 0, v, w), v, w, g


def is_density(v, g):
    return (v == 0) | (v > 1e-290)


@claim(2.5e-16, UNIT, G, is_valid=is_hg)
def hg_mu_where_it_is_small(xi, g):
    true = hg_mu(xi, g)
    return np.where(np.abs(true) < 0.25, np.abs(hg.sample_mu(xi, g) - true), 0)


@claim(8, UNIT, G, is_valid=is_hg)
def hg_mu_beyond(xi, g):
    true = hg_mu(xi, g)
    return np.where(np.abs(true) < 0.25, 0, ulps(hg.sample_mu(xi, g), true))


@claim(7, UNIT, G, is_valid=is_hg)
def hg_one_minus_mu(xi, g):
    return ulps(hg.sample_mu_sin(xi, g)[1], hg_ends(xi, g)[0])


@claim(7, UNIT, G, is_valid=is_hg)
def hg_sine(xi, g):
    minus, plus = hg_ends(xi, g)
    return ulps(hg.sample_mu_sin(xi, g)[2], np.sqrt(minus * plus))


@claim(9, uniform(0.0, 2.0), G, is_valid=is_density)
def hg_density(v, g):
    square, _, _, g_x = hg_parts(v, g)
    return ulps(hg.pdf_sr(v, g), (1 - g_x) * (1 + g_x) / (4 * PI * square * np.sqrt(square)))


@claim(7, uniform(0.0, 2.0), G, is_valid=is_density)
def hg_cdf(v, g):
    square, _, w, g_x = hg_parts(v, g)
    return ulps(hg.cdf(v, g), (1 - g_x) * w / (square + (1 + g_x) * np.sqrt(square)))


@claim(7, uniform(0.0, 2.0), G, is_valid=is_density)
def hg_survival(v, g):
    square, v_x, _, g_x = hg_parts(v, g)
    return ulps(hg.survival(v, g), (1 + g_x) * v_x / (square + (1 - g_x) * np.sqrt(square)))


# ---- Rayleigh ----


def rayleigh_density(mu, gamma):
    mu, gamma = extended(mu, gamma)
    return 3 * ((1 + 3 * gamma) + (1 - gamma) * mu * mu) / (8 * (1 + 2 * gamma))


@claim(5, uniform(-1.0, 1.0), UNIT)
def rayleigh_pdf_mu(mu, gamma):
    return ulps(rayleigh.pdf_mu(mu, gamma), rayleigh_density(mu, gamma))


@claim(6, uniform(-1.0, 1.0), UNIT)
def rayleigh_pdf_sr(mu, gamma):
    return ulps(rayleigh.pdf_sr(mu, gamma), rayleigh_density(mu, gamma) / (2 * PI))


@claim(6, uniform(-1.0, 1.0), UNIT)
def rayleigh_cdf(mu, gamma):
    m, c = extended(mu, gamma)
    return ulps(rayleigh.cdf_mu(mu, gamma), (1 + m) * ((3 + 9 * c) + (1 - c) * (m * m - m + 1)) / (8 * (1 + 2 * c)))


def rayleigh_angle(xi, gamma):
    """mu, 1 - mu and the sine, by Newton steps in mu, and in the distance to the nearer end."""
    x, gamma = extended(xi, gamma)
    k, scale = (1 - gamma) / (3 + 9 * gamma), 3 * (1 + 3 * gamma) / (8 * (1 + 2 * gamma))
    mu, tail = extended(rayleigh.sample_mu(xi, gamma.astype(float)))[0], np.minimum(x, 1 - x)
    for _ in range(4):
        mu -= (scale * (mu + k * mu**3) - (x - 0.5)) / (scale * (1 + 3 * k * mu * mu))
    end = np.where(np.abs(mu) < 0.999, 1 - np.abs(mu), tail / (scale * (1 + 3 * k)))
    for _ in range(4):
        q = 1 - end
        end -= (scale * end * (1 + k * (1 + q + q * q)) - tail) / (scale * (1 + 3 * k * q * q))
    one_minus = np.where(np.abs(mu) < 0.5, 1 - mu, np.where(x < 0.5, 2 - end, end))
    return mu, one_minus, np.sqrt(np.where(np.abs(mu) < 0.5, (1 - mu) * (1 + mu), end * (2 - end)))


@claim(4, UNIT, UNIT)
def rayleigh_mu(xi, gamma):
    return ulps(rayleigh.sample_mu(xi, gamma), rayleigh_angle(xi, gamma)[0])


@claim(6, UNIT, UNIT)
def rayleigh_one_minus_mu_and_sine(xi, gamma):
    _, minus, sine = rayleigh.sample_mu_sin(xi, gamma)
    _, true, true_sine = rayleigh_angle(xi, gamma)
    return np.maximum(ulps(minus, true), ulps(sine, true_sine))


# ---- lobes ----

SIDE = either_sign(1e-12, 1.0)
ROUGHNESS = Numbers(1e-4, 1e3, lambda rng, n: 10.0 ** rng.uniform(-4, 3, n))


def is_lobe(x, y, z, *parameters):
    return z > 1e-12


def density_error(kind, vector, true, *parameters):
    """Of `true(unit vector, parameters)`, in either precision."""
    worst = np.zeros(vector[0].shape)
    for dtype in (np.float64, np.float32):
        m = np.stack(vector, axis=-1).astype(dtype)
        given = [
            np.minimum(p.astype(dtype), 1 - np.finfo(dtype).epsneg if kind == "hg" else np.inf) for p in parameters
        ]
        unit = m.astype(Extended).T
        exact = true(*(unit / np.sqrt(np.sum(unit * unit, axis=0))), *extended(*given))
        found = lobes.pdf(kind, given[0], given[1] if len(given) == 2 else dtype(0), m)
        assert found.dtype == dtype
        is_normal = (exact > 100 * np.finfo(dtype).tiny) & (exact < np.finfo(dtype).max)
        worst = np.maximum(worst, np.where(is_normal, ulps(found, np.where(is_normal, exact, 1)), 0))
    return worst


@claim(18, SIDE, SIDE, SIDE, uniform(0.0, BELOW_ONE), is_valid=lambda x, y, z, g: np.abs(z) > 1e-12)
def lobe_density_hg(x, y, z, g):
    def true(ux, uy, uz, g):
        square = (1 - g) ** 2 + 2 * g * np.where(uz > 0, (ux * ux + uy * uy) / (1 + uz), 1 - uz)
        return (1 - g) * (1 + g) / (4 * PI * square * np.sqrt(square))

    return density_error("hg", (x, y, z), true, g)


@claim(12, SIDE, SIDE, SIDE, ROUGHNESS, ROUGHNESS, is_valid=is_lobe)
def lobe_density_ggx(x, y, z, alpha_x, alpha_y):
    def true(ux, uy, uz, a, b):
        return uz / (PI * a * b * ((ux / a) ** 2 + (uy / b) ** 2 + uz * uz) ** 2)

    return density_error("ggx", (x, y, z), true, alpha_x, alpha_y)


@claim(15, SIDE, SIDE, SIDE, ROUGHNESS, ROUGHNESS, is_valid=is_lobe)
def lobe_density_beckmann(x, y, z, alpha_x, alpha_y):
    """Over 1 + A / m_z^2."""

    def slope2(ux, uy, uz, a, b):
        return ((ux / a) ** 2 + (uy / b) ** 2) / (uz * uz)

    def true(ux, uy, uz, a, b):
        return np.exp(-slope2(ux, uy, uz, a, b)) / (PI * a * b * uz**3)

    return density_error("beckmann", (x, y, z), true, alpha_x, alpha_y) / (1 + slope2(x, y, z, alpha_x, alpha_y))


def sampled_lobe_error(kind, u, v, alpha_x, alpha_y):
    """In either precision; 1 and 0 are numbers like others."""
    worst = np.zeros(u.shape)
    for dtype in (np.float64, np.float32):
        given = [part.astype(dtype) for part in (alpha_x, alpha_y, u, v)]
        a, b, x, turn = extended(*given)
        sine, cosine = quarter_turns(4 * turn)
        is_edge = x == 1
        if kind == "ggx":
            radius, z = np.sqrt(x), np.sqrt(1 - x)
        else:
            radius, z = np.where(is_edge, 1, np.sqrt(-np.log1p(-np.where(is_edge, 0, x)))), np.where(is_edge, 0, 1)
        true = np.stack(np.broadcast_arrays(a * radius * cosine, b * radius * sine, z), axis=-1)
        true /= np.sqrt(np.sum(true * true, axis=-1, keepdims=True))
        found = lobes.sample(kind, *given)
        assert found.dtype == dtype
        is_normal = np.abs(true) > 100 * np.finfo(dtype).tiny
        worst = np.maximum(worst, np.max(np.where(is_normal, ulps(found, true), 0), axis=-1))
    return worst


@claim(8, UNIT, UNIT, uniform(0.0, BELOW_ONE), is_valid=lambda u, v, g: is_hg(u, g))
def lobe_sample_hg(u, v, g):
    """The cosine in ulp of 0.1 where it is smaller: its zero lies where nothing else is small."""
    worst = np.zeros(u.shape)
    for dtype in (np.float64, np.float32):
        given = [np.minimum(g, 1 - np.finfo(dtype).epsneg).astype(dtype), u.astype(dtype), v.astype(dtype)]
        minus, plus = hg_ends(given[1], given[0])
        side, (sine, cosine) = np.sqrt(minus * plus), quarter_turns(4 * given[2].astype(Extended))
        found = lobes.sample("hg", given[0], dtype(0), *given[1:])
        assert found.dtype == dtype
        for got, true in zip(found.T[:2], (side * cosine, side * sine), strict=True):
            worst = np.maximum(worst, np.where(np.abs(true) > 1e-30, ulps(got, true), 0))
        mu = hg_mu(given[1], given[0])
        spacing = np.spacing(np.maximum(np.abs(mu), 0.1).astype(dtype)).astype(Extended)
        worst = np.maximum(worst, np.abs(found[..., 2] - mu) / spacing)
    return worst


@claim(10, UNIT, UNIT, ROUGHNESS, ROUGHNESS)
def lobe_sample_ggx(*arguments):
    return sampled_lobe_error("ggx", *arguments)


@claim(10, UNIT, UNIT, ROUGHNESS, ROUGHNESS)
def lobe_sample_beckmann(*arguments):
    return sampled_lobe_error("beckmann", *arguments)


@claim(4, *[either_sign(1e-8, 1e8)] * 4)
def rotation_matrix(*quaternion):
    """Where little cancels in the true value."""
    w, x, y, z = extended(*quaternion)
    square, matrix = w * w + x * x + y * y + z * z, lobes.rotation_matrix(np.stack(quaternion, axis=-1))
    true = {(0, 0): w * w + x * x - y * y - z * z, (0, 1): 2 * (x * y - w * z), (2, 2): w * w + z * z - x * x - y * y}
    each = [ulps(matrix[..., i, j], value / square) for (i, j), value in true.items()]
    return np.max([np.where(np.abs(v) > 0.1 * square, e, 0) for e, v in zip(each, true.values(), strict=True)], axis=0)


# ---- angles, elementary functions and the laws of cells ----


@claim(2.5, either_sign(1e-18, 720.0))
def sine_and_cosine_of_degrees(degrees):
    true = quarter_turns(degrees.astype(Extended), 90)
    return np.max([np.where(t != 0, ulps(x, t), 0) for x, t in zip(sin_cos_deg(degrees), true, strict=True)], axis=0)


@claim(1, either_sign(1e-3, 720.0))
def degrees_and_radians(degrees):
    (x,) = extended(degrees)
    radians, back = given_angle("zenith_rad", None, degrees), given_angle("zenith_deg", None, degrees)
    return np.maximum(ulps(radians, x * PI / 180), ulps(back, x * 180 / PI))


def series_error(series, r, dtype):
    """In ulp of the result, for a cosine next to 0 in that of 1."""
    r = r.astype(dtype)
    angle = r.astype(Extended) * (PI / 2)
    sine, cosine = series(r)
    return np.maximum(ulps(sine, np.sin(angle)), ulps(cosine, np.cos(angle)))


@claim(2, either_sign(1e-20, 0.5))
def series_for_a_quarter(r):
    return np.maximum(*(series_error(elementary.sincos_quarter, r, kind) for kind in (np.float64, np.float32)))


@claim(1, either_sign(1e-300, 1e300), is_valid=lambda x: x > 1e-307)
def logarithm(x):
    return np.where(x == 1, 0, ulps(elementary.log_level(x), np.log(x.astype(Extended))))


@claim(1, either_sign(1e-20, 700.0))
def exponential(x):
    return ulps(elementary.exp_level(x), np.exp(x.astype(Extended)))


@claim(2, UNIT, is_valid=lambda h: h > 0)
def arc(h):
    true = 2 * np.arctan2(np.sqrt(h.astype(Extended)), np.sqrt(1 - h.astype(Extended)))
    return np.where(true <= 2 * PI / 3, ulps(elementary.arc(h), true), np.abs(elementary.arc(h) - true) / 2.0**-51)


def is_cell(near, far, *others):
    return near <= far


def length_error(law, dtype, near, far, azimuth, half_width, u, v):
    """Of the direction of a photon in a cell: its length less 1."""
    if law is laws.from_mu2:
        sine, cosine = sin_cos_deg([near, far - near, far + near, far])
        head = sine[0] ** 2, sine[1] * sine[2], cosine[3] ** 2
    else:
        sine = sin_cos_deg([near / 2, (far + near) / 2, (far - near) / 2])[0]
        head = 2 * sine[0] ** 2, 2 * sine[1] * sine[2], sin_cos_deg(far)[1]
    cell = [x.astype(dtype) for x in (*head, *sin_cos_deg(azimuth), half_width)]
    u, v = (np.minimum(x.astype(dtype), 1 - np.finfo(dtype).epsneg) for x in (u, v))
    vector = law(*cell[:3], u, *elementary.sincos_turned_any(*cell[3:], v))
    assert vector[0].dtype == dtype
    return np.abs(np.sqrt(sum(x * x for x in extended(*vector))) - 1)


UNIT_NUMBER = uniform(0.0, BELOW_ONE)
CELL = (uniform(0.0, 90.0), uniform(0.0, 90.0), uniform(-360.0, 360.0), uniform(0.0, 2.0), UNIT_NUMBER, UNIT_NUMBER)


@claim(3.5e-7, *CELL, is_valid=is_cell)
def length_of_directions_float32(*cell):
    return np.maximum(*(length_error(law, np.float32, *cell) for law in (laws.from_mu2, laws.from_mu)))


@claim(8.5e-16, *CELL, is_valid=is_cell)
def length_of_directions_float64(*cell):
    return np.maximum(*(length_error(law, np.float64, *cell) for law in (laws.from_mu2, laws.from_mu)))


@claim(3.5, uniform(-2.0, 2.0), uniform(0.0, 2.0), UNIT_NUMBER)
def azimuth_in_a_cell(centre, half_width, v):
    """In ulp of 1, in either precision."""
    worst = np.zeros(v.shape)
    for kind in (np.float64, np.float32):
        sine, cosine, w, share = (x.astype(kind) for x in (*quarter_turns(centre.astype(Extended)), half_width, v))
        turned = elementary.sincos_turned_any(sine, cosine, w, share)
        s, c, w, share = extended(sine, cosine, w, share)
        turn_sine, turn_cosine = quarter_turns(w * (2 * share - 1))
        for x, true in zip(turned, (s * turn_cosine + c * turn_sine, c * turn_cosine - s * turn_sine), strict=True):
            worst = np.maximum(worst, np.abs(x - true) / np.finfo(kind).eps)
    return worst


@claim(2, uniform(-elementary.NARROW_HALF_WIDTH, elementary.NARROW_HALF_WIDTH))
def short_series(r):
    """In ulp of the sine, and of 1 over 0.35 for the cosine."""
    worst = np.zeros(r.shape)
    for kind in (np.float64, np.float32):
        x = r.astype(kind)
        sine, cosine = elementary.sincos_narrow(x)
        true_sine, true_cosine = quarter_turns(x.astype(Extended))
        off_sine, off_cosine = np.abs(sine - true_sine), np.abs(cosine - true_cosine)
        errors = off_sine / np.where(true_sine == 0, 1, np.abs(true_sine)), off_cosine / 0.35
        worst = np.maximum(worst, np.maximum(*errors) / np.finfo(kind).eps)
    return worst


@claim(2, UNIT_NUMBER, uniform(-MAX_SLOPE, MAX_SLOPE))
def place_on_a_slope(u, slope):
    """In ulp of 1, of the u that the place belongs to."""
    s, x = extended(slope, laws._on_slope(u, slope))
    return np.where(x < BELOW_ONE, np.abs((1 - s) * x + s * x * x - u) / 2.0**-52, 0)


# ---- Perez and polarisation ----


@claim(5, uniform(0.0, 1500.0), uniform(1e-3, 1000.0), uniform(0.0, np.pi / 2))
def sky_clearness(dni, dhi, zenith):
    n, h, z = extended(dni, dhi, zenith)
    return ulps(sky.perez.sky_clearness(dni, dhi, zenith), 1 + n / h / (1 + Extended("1.041") * z**3))


@claim(4e-18, uniform(1e-12, 1e3))
def logarithm_in_two_parts(x):
    """Over the larger of 1 and the logarithm."""
    head, tail = extended(*coefficients.log(x))
    return np.abs(head + tail - np.log(x.astype(Extended))) / np.maximum(np.abs(head), 1)


@claim(2, uniform(1e-20, 700.0))
def exponential_less_1(x):
    return ulps(coefficients.expm1(x), np.expm1(x.astype(Extended)))


@claim(2, uniform(1e-8, 1e4), uniform(-2e4, 3e4), is_valid=lambda x, p: np.rint(p) != 0)
def power(x, ten_thousandths):
    p = np.rint(ten_thousandths)
    true = np.exp(np.log(x.astype(Extended)) * (p.astype(Extended) / 10_000))
    return np.where((true > 1e-290) & (true < 1e290), ulps(coefficients.power(x, p), true), 0)


ENDS = ((-3.0, 5.0), (-4.0, -1e-6), (-5.0, 60.0), (-10.0, -1e-2), (-1.0, 2.0))
COEFFICIENTS = tuple(uniform(*ends) for ends in ENDS)


@claim(2e-15, uniform(0.0, 1.5707), uniform(-np.pi, np.pi), uniform(0.0, np.pi / 2), *COEFFICIENTS)
def relative_radiance(zenith, azimuth, sun, *coefficient):
    """Over 1 + |b| / mu^2 and the sums of magnitudes of both factors."""
    z, y, s, a, b, c, d, e = extended(zenith, azimuth, sun, *coefficient)
    h = np.sin((z - s) / 2) ** 2 + np.sin(z) * np.sin(s) * np.sin(y / 2) ** 2
    gamma, mu = 2 * np.arctan2(np.sqrt(h), np.sqrt(np.maximum(1 - h, 0))), np.cos(z)
    terms = a * np.exp(b / mu), c * np.exp(d * gamma), e * (1 - 2 * h) ** 2
    true, sizes = ((1 + t[0]) * (1 + t[1] + t[2]) for t in (terms, [np.abs(term) for term in terms]))
    found = sky.perez.relative_radiance(zenith, azimuth, sun, np.stack(coefficient, axis=-1))
    return np.abs(found - true) / (sizes * (1 + np.abs(b) / mu**2))


@claim(3e-15, uniform(0.0, np.pi / 2), uniform(0.0, 2 * np.pi))
def polarisation(zenith, azimuth):
    """For some suns; q and u."""
    z, a = extended(zenith, azimuth)
    worst = np.zeros(z.shape)
    for sun, sun_azimuth in ((0.0, 0.0), (0.6, -3.1), (1.1, 6.2), (np.pi / 2, 4.7), (1e-9, 1.0)):
        turn, sine, cosine = a - Extended(sun_azimuth), np.sin(Extended(sun)), np.cos(Extended(sun))
        along, across = -sine * np.sin(turn), sine * np.cos(z) * np.cos(turn) - cosine * np.sin(z)
        scale = 1 / (1 + (sine * np.sin(z) * np.cos(turn) + cosine * np.cos(z)) ** 2)
        q, u = sky.RayleighPattern(max_degree=1.0).stokes(
            zenith, azimuth, sun_zenith_rad=sun, sun_azimuth_rad=sun_azimuth
        )
        for got, true in ((q, scale * (along - across) * (along + across)), (u, 2 * scale * along * across)):
            worst = np.maximum(worst, np.abs(got - true))
    return worst


@pytest.mark.parametrize("is_full", [False, pytest.param(True, marks=pytest.mark.slow)], ids=["quick", "full"])
@pytest.mark.parametrize("name", CLAIMS)
def test_no_error_is_larger(name, is_full):
    error, bound, numbers, is_valid = CLAIMS[name]
    found, where = largest_error(error, numbers, is_valid, is_full=is_full)
    assert found <= bound, f"{found:.3f} at {where}"
    assert found > 0.2 * bound, "the bound is far too wide, or the search finds nothing"
