"""Twin of the Perez sky in 40-digit arithmetic: from the paper, sharing nothing with the package.

Numbers given as text are taken as the decimals they are written as.
"""

import mpmath as mp

# Table 1, two lines for a bin: a, b and c, then d and e, four terms each
TABLE = """
1.3525 -0.2576 -0.2690 -1.4366  -0.7670 0.0007 1.2734 -0.1233  2.8000 0.6004 1.2375 1.0000
1.8734 0.6297 0.9738 0.2809  0.0356 -0.1246 -0.5718 0.9938
-1.2219 -0.7730 1.4148 1.1016  -0.2054 0.0367 -3.9128 0.9156  6.9750 0.1774 6.4477 -0.1239
-1.5798 -0.5081 -1.7812 0.1080  0.2624 0.0672 -0.2190 -0.4285
-1.1000 -0.2515 0.8952 0.0156  0.2782 -0.1812 -4.5000 1.1766  24.7219 -13.0812 -37.7000 34.8438
-5.0000 1.5218 3.9229 -2.6204  -0.0156 0.1597 0.4199 -0.5562
-0.5484 -0.6654 -0.2672 0.7117  0.7234 -0.6219 -5.6812 2.6297  33.3389 -18.3000 -62.2500 52.0781
-3.5000 0.0016 1.1477 0.1062  0.4659 -0.3296 -0.0876 -0.0329
-0.6000 -0.3566 -2.5000 2.3250  0.2937 0.0496 -5.6812 1.8415  21.0000 -4.7656 -21.5906 7.2492
-3.5000 -0.1554 1.4062 0.3988  0.0032 0.0766 -0.0656 -0.1294
-1.0156 -0.3670 1.0078 1.4051  0.2875 -0.5328 -3.8500 3.3750  14.0000 -0.9999 -7.1406 7.5469
-3.4000 -0.1078 -1.0750 1.5702  -0.0672 0.4016 0.3017 -0.4844
-1.0000 0.0211 0.5025 -0.5119  -0.3000 0.1922 0.7023 -1.6317  19.0000 -5.0000 1.2438 -1.9094
-4.0000 0.0250 0.3844 0.2656  1.0468 -0.3788 -2.4517 1.4656
-1.0500 0.0289 0.4260 0.3590  -0.3250 0.1156 0.7781 0.0025  31.0625 -14.5000 -46.1148 55.3750
-7.2312 0.4050 13.3500 0.6234  1.5000 -0.6426 1.8564 0.5636
"""

WORDS = TABLE.split()
ROWS = [[mp.mpf(word) for word in WORDS[20 * row : 20 * row + 20]] for row in range(8)]


def coefficients(row, delta, zenith_deg):
    """a to e of bin `row` (0 to 7), eqs. (6) to (8), without limits."""
    with mp.workdps(40):
        brightness, zenith = mp.mpf(delta), mp.radians(mp.mpf(zenith_deg))
        terms = [mp.mpf(word) for word in WORDS[20 * row : 20 * row + 20]]
        values = []
        for start in range(0, 20, 4):
            x1, x2, x3, x4 = terms[start : start + 4]
            if row == 0 and start == 8:
                values.append(mp.exp((brightness * (x1 + x2 * zenith)) ** x3) - x4)
            elif row == 0 and start == 12:
                values.append(-mp.exp(brightness * (x1 + x2 * zenith)) + x3 + brightness * x4)
            else:
                values.append(x1 + x2 * zenith + brightness * (x3 + x4 * zenith))
        return values


def gamma(sky_zenith_deg, azimuth_deg, zenith_deg):
    """Angle between a point of the sky and the sun. [rad]"""
    with mp.workdps(60):
        xi, phi, sun = (mp.radians(mp.mpf(text)) for text in (sky_zenith_deg, azimuth_deg, zenith_deg))
        dot = mp.cos(xi) * mp.cos(sun) + mp.sin(xi) * mp.sin(sun) * mp.cos(phi)
        return mp.acos(min(max(dot, mp.mpf(-1)), mp.mpf(1)))


def luminance(values, sky_zenith_deg, azimuth_deg, zenith_deg):
    """f of eq. (1) off the horizon, and the product of its factors' sums of magnitudes."""
    with mp.workdps(60):
        a, b, c, d, e = values
        angle = gamma(sky_zenith_deg, azimuth_deg, zenith_deg)
        layer = a * mp.exp(b / mp.cos(mp.radians(mp.mpf(sky_zenith_deg))))
        aureole, back = c * mp.exp(d * angle), e * mp.cos(angle) ** 2
        value = (1 + layer) * (1 + aureole + back)
        return value, (1 + abs(layer)) * (1 + abs(aureole) + abs(back))
